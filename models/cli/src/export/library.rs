//! The shared library that exports contain.

use std::path::PathBuf;

use crate::Failure;

/// Its name.
pub const FILE: &str = "libpneudrive_capi.so";

/// Which library goes into an export.
#[derive(Debug, clap::Args)]
pub struct LibraryArgs {
    /// The library of the C interface [default: libpneudrive_capi.so beside this program, or in
    /// ../lib]
    #[arg(long, value_name = "FILE.so")]
    library: Option<PathBuf>,
}

impl LibraryArgs {
    /// Finds it.
    pub fn find(&self) -> Result<PathBuf, Failure> {
        if let Some(given) = &self.library {
            return if given.is_file() {
                Ok(given.clone())
            } else {
                Err(Failure::input(format!("{}: there is no such file", given.display())))
            };
        }
        let program = std::env::current_exe().ok();
        let folder = program.as_deref().and_then(std::path::Path::parent);
        let places = folder.map(|f| [f.join(FILE), f.join("../lib").join(FILE)]).into_iter().flatten();
        places.into_iter().find(|path| path.is_file()).ok_or_else(|| {
            Failure::input(format!(
                "{FILE} is neither beside this program nor in ../lib; build it with \
`cargo build --release -p pneudrive-capi`, or name it with --library"
            ))
        })
    }
}
