//! The host's library, as users meet it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod checked;
mod echo;
mod examples;
mod false_address;
mod limits;
mod line_rate_refusals;
mod loop_rate;
mod losses;
mod lost_line;
mod pages;
mod port;
mod presence;
mod resync;
mod safe_state;
mod sensors;
mod session;
mod support;
mod wall_clock;
