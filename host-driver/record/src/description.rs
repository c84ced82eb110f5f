//! What a recording says of itself: lines `# key: value` above the header of a table, the metadata
//! record `pneudrive` of a bag.

use pneudrive_host::Calibration;
use pneudrive_protocol::SensorScale;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;

/// What a recording says of itself, in the order in which it was said. Values are JSON.
///
/// The recorder adds `pneudrive_recording` (the version of the format), `program` and its version
/// unless they are given, `created_utc`, `boards` and `sensor`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    entries: Vec<(String, String)>,
}

/// What boards are asked for in pages, and recordings have columns for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PageColumns {
    /// The valves' drives: of a run with
    /// [`PollerOptions::drives`](pneudrive_host::poller::PollerOptions::drives).
    pub drives: bool,
    /// Supply pressure and IMU: of a run with
    /// [`PollerOptions::sensors`](pneudrive_host::poller::PollerOptions::sensors).
    pub sensors: bool,
}

impl RecorderOptions {
    /// The standard atmosphere, kPa.
    pub const STANDARD_ATMOSPHERE_KPA: f64 = 101.325;

    /// Replaces a file that exists, or refuses to.
    #[must_use]
    pub fn overwrite(mut self, overwrite: bool) -> Self {
        self.overwrite = overwrite;
        self
    }

    /// Has columns for these pages.
    #[must_use]
    pub fn pages(mut self, pages: PageColumns) -> Self {
        self.pages = pages;
        self
    }

    /// Adds this pressure of the atmosphere, kPa absolute; `None` is the standard one.
    #[must_use]
    pub fn ambient_kpa(mut self, ambient_kpa: Option<f64>) -> Self {
        self.ambient_kpa = ambient_kpa;
        self
    }

    /// Says this of itself.
    #[must_use]
    pub fn description(mut self, description: Description) -> Self {
        self.description = description;
        self
    }
}

/// What is given to a [`Recorder`](super::Recorder) beside its file.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct RecorderOptions {
    /// Whether a file that exists is replaced.
    pub overwrite: bool,
    /// What it has beside commands and pressures.
    pub pages: PageColumns,
    /// Pressure of the atmosphere, kPa absolute: added to supply pressures where ROS wants them
    /// absolute. `None` is the standard atmosphere.
    pub ambient_kpa: Option<f64>,
    /// What the recording shall say of itself.
    pub description: Description,
}

impl Description {
    /// Version of the format, in the entry `pneudrive_recording`. It grows when a reader of the
    /// older format would misread the newer.
    pub const FORMAT: u32 = 1;

    /// The same with an entry. A second value for a key replaces the first. What JSON cannot
    /// express (a map whose keys are no strings) is left out.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Serialize) -> Self {
        let Ok(json) = serde_json::to_string(&value) else { return self };
        match self.entries.iter_mut().find(|(known, _)| known == key) {
            Some((_, old)) => *old = json,
            None => self.entries.push((key.to_owned(), json)),
        }
        self
    }

    /// Keys, and values as JSON.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// What every recording says, then what is in `self`.
    pub(super) fn complete(&self, boards: &[Vec<u8>], calibration: &Calibration) -> Self {
        let now = humantime::format_rfc3339_millis(std::time::SystemTime::now()).to_string();
        let numbers = |scale: SensorScale| json!({ "zero_counts": scale.zero_counts(), "kpa_per_count": scale.kpa_per_count() });
        let sensor = numbers(calibration.usual());
        let own: BTreeMap<u8, _> =
            calibration.boards().map(|board| (board, calibration.of(board).map(numbers))).collect();
        let always = Self::default()
            .with("pneudrive_recording", Self::FORMAT)
            .with("program", concat!("pneudrive-host ", env!("CARGO_PKG_VERSION")))
            .with("created_utc", now);
        let always = match boards {
            [only] => always.with("boards", only),
            several => always.with("boards", several),
        };
        let mut always = always.with("sensor", sensor);
        if !own.is_empty() {
            always = always.with("calibration", own);
        }
        self.entries.iter().fold(always, |mut all, (key, value)| {
            all.entries.retain(|(known, _)| known != key);
            all.entries.push((key.clone(), value.clone()));
            all
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_json_and_the_last_one_counts() {
        let description = Description::default()
            .with("port", "sim")
            .with("rate_hz", None::<f64>)
            .with("rig", "[supply]\npressure_kpa = 550.0\n")
            .with("port", "/dev/tty\"x");
        let entries: Vec<_> = description.entries().collect();
        let rig = r#""[supply]\npressure_kpa = 550.0\n""#;
        assert_eq!(entries, [("port", r#""/dev/tty\"x""#), ("rate_hz", "null"), ("rig", rig)]);
    }
}
