//! Recordings by button.

use crate::run::Refusal;
use std::path::{Path, PathBuf};

/// Makes recordings, one at a time. `start` and `stop` may wait for a disk: they are called on a
/// thread that serves nobody else.
pub trait Recordings: Send + Sync + 'static {
    /// The folder, for people.
    fn folder(&self) -> &Path;

    /// Starts a recording whose file's name contains `name`. Returns the file.
    ///
    /// # Errors
    /// One is in progress already, or the file cannot be made.
    fn start(&self, name: &str) -> Result<PathBuf, Refusal>;

    /// Stops it.
    ///
    /// # Errors
    /// There is none.
    fn stop(&self) -> Result<(), Refusal>;

    /// What is going on now.
    fn status(&self) -> RecordingStatus;

    /// The recordings made by button in this run, in the order in which they were started.
    fn made(&self) -> Vec<MadeRecording>;
}

/// A recording made by button.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct MadeRecording {
    /// Its file's name.
    pub name: String,
    /// Where it is.
    #[serde(skip)]
    pub file: PathBuf,
    /// Bytes on the disk.
    pub bytes: u64,
    /// Whether it is complete.
    pub whole: bool,
}

/// What is being recorded by button.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct RecordingStatus {
    /// The one in progress: its file's name, and bytes on the disk.
    pub running: Option<(String, u64)>,
    /// Whether the last rows of the one before are still being written.
    pub finishing: bool,
    /// What became of the one before, for people.
    pub last: Option<String>,
    /// Whether the one before failed.
    pub failed: bool,
}

/// Whether a recording may be called so: names with dots or slashes could leave the folder.
pub(crate) fn check_name(name: &str) -> Result<(), Refusal> {
    const LONGEST: usize = 40;
    if name.len() > LONGEST || !name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b)) {
        let message = format!("a recording's name has at most {LONGEST} letters, digits, - and _");
        return Err(Refusal::Unusable(message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder() {
        for good in ["", "grasp", "take-1_b"] {
            assert_eq!(check_name(good), Ok(()), "{good}");
        }
        for bad in ["..", "a/b", "a b", "a.csv", "é", &"x".repeat(41)] {
            assert!(check_name(bad).is_err(), "{bad}");
        }
    }
}
