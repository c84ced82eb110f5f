//! What recordings hold, whoever reads them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod foxglove;
mod recording;
#[path = "../../tests/support/mod.rs"]
#[allow(dead_code, reason = "ptys are for other tests")]
mod support;
