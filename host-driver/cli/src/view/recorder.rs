//! Recordings by a key.

use crate::setup::Setup;
use pneudrive_host::poller::Observer;
use pneudrive_record::{Description, PageColumns, RecordError, RecordSwitch, RecordingSummary};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

/// Starts and stops recordings of the run in the working folder.
#[derive(Clone)]
pub struct KeyRecorder(Arc<RecordSwitch>);

impl KeyRecorder {
    /// The recorder, and the observer that is to be given to the poller.
    pub fn new(
        boards: &[u8],
        setup: &Setup,
        description: &Description,
        pages: PageColumns,
    ) -> (Self, Box<dyn Observer>) {
        let (switch, tap) = RecordSwitch::new(boards, setup.calibration.clone());
        (Self(Arc::new(switch.describe(description.clone()).with_pages(pages, setup.ambient_kpa()))), tap)
    }

    /// For events that do not happen on the bus.
    pub fn notes(&self) -> pneudrive_record::Notes {
        self.0.notes()
    }

    /// The file that is being written.
    pub fn running(&self) -> Option<PathBuf> {
        self.0.status().running
    }

    /// Starts a recording, or stops the one in progress; what became of it, in words.
    pub fn toggle(&self) -> Result<String, String> {
        if let Some(file) = self.running() {
            self.0.stop().map_err(|error| error.to_string())?;
            return Ok(format!("recorded {}", file.display()));
        }
        let now = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        // As ISO 8601's basic format has it: colons are trouble in file names.
        let file = PathBuf::from(format!("{}.csv.zst", now.replace(['-', ':'], "")));
        self.0.start(&file).map_err(|error| error.to_string())?;
        Ok(format!("recording {}", file.display()))
    }

    /// Ends the recording in progress, when the poller has ended.
    pub fn finish(&self) -> Result<Option<RecordingSummary>, RecordError> {
        self.0.finish().transpose()
    }
}
