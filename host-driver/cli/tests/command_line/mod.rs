//! The program as users run it: what it refuses, what it leaves behind, how it ends.

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
mod trajectories;
mod watch;
