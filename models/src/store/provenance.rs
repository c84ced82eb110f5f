//! Where parameters came from.

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

/// The rig file as given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RigSource {
    /// The file as given.
    pub file: String,
}
