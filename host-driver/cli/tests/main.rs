//! The program `pneudrive-host`, as users meet it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod command_line;
mod real_time;
mod rig;
mod robustness;
#[cfg(feature = "sim")]
mod sim;
#[path = "../../tests/support/mod.rs"]
#[allow(dead_code, reason = "virtual time is for the library's tests")]
mod support;
mod terminal;
#[cfg(feature = "web")]
mod web;
