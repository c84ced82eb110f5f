//! Recordings by the page's button.

use pneudrive_page::{MadeRecording, RecordingStatus, Recordings, Refusal};
use pneudrive_record::{RecordError, RecordSwitch, SwitchError};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

/// Recordings by button.
#[derive(Debug)]
pub struct Recording {
    /// Makes them.
    pub switch: RecordSwitch,
    /// Where they go.
    pub folder: PathBuf,
    /// Ending of their names, which is their format: `csv.zst`.
    pub ending: String,
}

/// What the page's button does.
pub(super) fn by_button(recording: Arc<Recording>) -> Box<dyn Recordings> {
    Box::new(ByButton { recording, made: Mutex::default() })
}

struct ByButton {
    recording: Arc<Recording>,
    /// Files that were started.
    made: Mutex<Vec<PathBuf>>,
}

impl Recordings for ByButton {
    fn folder(&self) -> &Path {
        &self.recording.folder
    }

    fn start(&self, name: &str) -> Result<PathBuf, Refusal> {
        let file = self.recording.file(name);
        let made = self.recording.bag_folder(&file).map_err(Refusal::Failed)?;
        self.recording.switch.start(&file).map_err(|error| {
            if made && let Some(folder) = file.parent() {
                // It is empty, or it stays.
                let _ = fs::remove_dir(folder);
            }
            refusal(&error)
        })?;
        self.made.lock().unwrap_or_else(PoisonError::into_inner).push(file.clone());
        Ok(file)
    }

    fn stop(&self) -> Result<(), Refusal> {
        self.recording.switch.stop().map_err(|error| refusal(&error))
    }

    fn made(&self) -> Vec<MadeRecording> {
        let status = self.recording.switch.status();
        let files = self.made.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let last = files.len().saturating_sub(1);
        let made = files.into_iter().enumerate().map(|(number, file)| MadeRecording {
            name: name_of(&file),
            bytes: file.metadata().map_or(0, |status| status.len()),
            whole: number < last || (status.running.is_none() && !status.finishing),
            file,
        });
        made.collect()
    }

    fn status(&self) -> RecordingStatus {
        let status = self.recording.switch.status();
        RecordingStatus {
            running: status.running.map(|file| {
                let bytes = file.metadata().map_or(0, |status| status.len());
                (name_of(&file), bytes)
            }),
            finishing: status.finishing,
            failed: matches!(status.last, Some(Err(_))),
            last: status.last.map(|last| match last {
                Ok(summary) => {
                    format!("{}: {} rows, {} bytes", name_of(&summary.file), summary.rows, summary.bytes)
                }
                Err(error) => error.to_string(),
            }),
        }
    }
}

fn refusal(error: &SwitchError) -> Refusal {
    match error {
        SwitchError::Running { .. }
        | SwitchError::NotRunning
        | SwitchError::Record(RecordError::Exists { .. }) => Refusal::Conflict(error.to_string()),
        _ => Refusal::Failed(error.to_string()),
    }
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

impl Recording {
    /// A new file: the time, and what the user calls it. A bag has a folder of its own of this
    /// name, as `ros2 bag` makes them: its metadata.yaml has the same name in all of them.
    fn file(&self, name: &str) -> PathBuf {
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        // As ISO 8601's basic format has it, 20261121T163343Z: colons are trouble in file names.
        let now = now.replace(['-', ':'], "");
        let label = if name.is_empty() { String::new() } else { format!("-{name}") };
        let stem = format!("{now}{label}");
        let name = format!("{stem}.{}", self.ending);
        let folder = if self.ending == "mcap" { self.folder.join(stem) } else { self.folder.clone() };
        folder.join(name)
    }

    /// Makes the folder of a bag, if `file` has one; returns whether it did.
    fn bag_folder(&self, file: &Path) -> Result<bool, String> {
        match file.parent() {
            Some(folder) if folder != self.folder && !folder.exists() => match fs::create_dir(folder) {
                Ok(()) => Ok(true),
                Err(error) => Err(format!("{}: {error}", folder.display())),
            },
            _ => Ok(false),
        }
    }
}
