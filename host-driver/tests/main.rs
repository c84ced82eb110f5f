//! The host's library and program, as users meet them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod checked;
mod command_line;
mod echo;
mod examples;
mod false_address;
mod foxglove;
mod limits;
mod line_rate_refusals;
mod loop_rate;
mod losses;
mod lost_line;
mod pages;
mod port;
mod presence;
mod real_time;
mod recording;
mod resync;
mod rig;
mod robustness;
mod safe_state;
mod sensors;
mod session;
mod sim;
mod support;
mod terminal;
mod wall_clock;
mod web;
