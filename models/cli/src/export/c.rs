//! `pneudrive-model export c`

use super::library::{FILE, LibraryArgs};
use super::{Failure, From};

/// Header of the C interface and the example, as the library's own folder has them.
pub const HEADER: &str = include_str!("../../../../capi/include/pneudrive.h");
const EXAMPLE: &str = include_str!("../../../../capi/examples/step.c");

/// A folder that a C or C++ program simulates the chambers with
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  \
pneudrive-model export c --parameters extended.toml --out chamber\n  \
cd chamber\n  \
cc step.c -I. -L. -lpneudrive_capi -Wl,-rpath,'$ORIGIN' -o step\n  \
./step parameters.toml b0c0 150\n\n\
pneudrive.h documents every function; the library needs nothing but the C library.")]
pub struct Args {
    #[command(flatten)]
    from: From,
    #[command(flatten)]
    library: LibraryArgs,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        self.from.load()?;
        let library = self.library.find()?;
        self.from.make_folder()?;
        self.from.copy_parameters()?;
        self.from.copy(&library, FILE)?;
        self.from.text("pneudrive.h", HEADER)?;
        self.from.text("step.c", EXAMPLE)
    }
}
