//! The C interface, as programs in C and simulators use it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod c_example;
mod creation;
mod extended;
mod fitted;
mod header;
mod input_slopes;
mod rollouts;
mod state;
mod support;
