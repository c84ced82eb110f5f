//! The rig file, as its readers use it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod ranges;
mod reader;
mod schema;
