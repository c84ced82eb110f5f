//! The host with virtual boards: in virtual time, and over ptys.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod boards;
mod faults;
mod killed_recording;
mod line_rate;
mod original_boards;
mod parameters;
mod recording;
mod rig_file;
mod sensors;
mod target;
mod update;
