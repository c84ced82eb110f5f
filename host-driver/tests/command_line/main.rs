//! The program as users run it: what it refuses, what it leaves behind, how it ends.

#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used)]

mod board;
mod check;
mod endings;
#[cfg(feature = "web")]
mod page;
mod program;
mod recordings;
mod refusals;
mod replay;
mod schema;
mod sensors;
mod subcommands;
#[path = "../support/mod.rs"]
mod support;
mod trajectories;
mod watch;
