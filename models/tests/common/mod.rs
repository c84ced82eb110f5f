//! What the tests of files and of the command line share.
pub mod cli;

use std::io::Write;
use std::path::{Path, PathBuf};

/// A temporary folder with files in it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("writable");
        path
    }

    /// A message without this folder's path.
    pub fn strip(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.0.path().display()), "")
    }

    /// Names of the files in the folder, hidden ones too.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("readable");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("readable").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

pub fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(content).expect("memory");
    encoder.finish().expect("memory")
}

/// The folder of real recordings, or `None` with a message on the terminal that says how to have these tests run.
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
