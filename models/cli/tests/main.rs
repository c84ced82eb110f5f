//! The program `pneudrive-model`, as users meet it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod asked_effects;
mod bad_recordings;
mod command_line;
mod common;
mod export_command;
mod extended_model;
mod manual_command;
mod outputs;
mod real_recordings;
mod several_recordings;
mod simulate_command;
mod trends_command;
