//! What the tests of files and of the command line share.
pub mod cli;
mod folder;
pub mod regulator;

use std::io::Write as _;
use std::path::PathBuf;

pub use folder::Folder;

/// The folder of real recordings, or `None` with a message on the terminal that says how to have
/// these tests run.
pub fn real_data(test: &str) -> Option<PathBuf> {
    match std::env::var_os("PNEUDRIVE_DATA") {
        Some(folder) => Some(PathBuf::from(folder)),
        None => {
            // Standard error of the process itself: the test harness captures `eprintln!`.
            let _ = writeln!(
                std::io::stderr(),
                "\nSKIPPED {test}: set PNEUDRIVE_DATA to the folder with the recordings (it holds respiraworks/)"
            );
            None
        }
    }
}
