//! Where the program is.

use super::WatchError;
use std::path::{Path, PathBuf};

const NAME: &str = "pneudrive-model";

/// The program: as given, else beside this one, else on the search path.
pub(super) fn find(given: Option<&Path>) -> Result<PathBuf, WatchError> {
    let beside = || Some(std::env::current_exe().ok()?.with_file_name(NAME));
    let path = std::env::var_os("PATH").unwrap_or_default();
    match given {
        Some(given) if given.is_file() => Ok(given.to_owned()),
        Some(given) => Err(WatchError::NoProgram { program: given.display().to_string() }),
        None => beside()
            .into_iter()
            .chain(std::env::split_paths(&path).map(|folder| folder.join(NAME)))
            .find(|candidate| candidate.is_file())
            .ok_or(WatchError::NoProgram { program: NAME.to_owned() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let error = find(Some(Path::new("/nowhere/model"))).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/model: not found") && error.contains("install it"), "{error}");
        let this = std::env::current_exe().unwrap();
        assert_eq!(find(Some(&this)), Ok(this));
    }
}
