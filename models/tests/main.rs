//! The toolkit's library and program, as users meet them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod bad_recordings;
mod command_line;
mod common;
mod data_errors;
mod data_quality;
mod effects;
mod engine;
mod export_command;
mod extended_model;
mod manual_command;
mod outputs;
mod own_tables;
mod real_recordings;
mod rig_file;
mod trends_command;
