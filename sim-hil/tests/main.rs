//! The virtual boards and recordings of the plant, as hosts and the diagnosis meet them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod bus_counters;
mod closed_loop;
mod common;
mod faults;
mod firmware;
mod original_board;
mod original_defects;
mod process;
mod pty;
mod recordings;
