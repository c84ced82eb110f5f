//! The emulated chip, as the firmware and a debugger use it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod common;
mod debugger;
mod loading;
mod running;
