//! Where parameters came from.

use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::data::Source;

/// Enough to find the data again, to know that they are the same, and to repeat the fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// Date and time, RFC 3339, UTC.
    pub created: String,
    /// The command line.
    pub command: String,
    /// The recording.
    pub data: Source,
    /// The rig file, if one was given; its content is in the file too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<RigSource>,
}

impl Provenance {
    /// Of something made now from `data` by a program that calls this library.
    #[must_use]
    pub fn now(data: &Source) -> Self {
        Self {
            program: concat!("pneudrive-model ", env!("CARGO_PKG_VERSION")).to_owned(),
            created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
            command: std::env::args().next().unwrap_or_default(),
            data: data.clone(),
            rig: None,
        }
    }
}

/// The rig file as given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigSource {
    /// The file as given.
    pub file: String,
}
