//! What the host's system tests share: a bus to test on, and the simulator's bus in virtual time.

#![allow(dead_code, unused_imports, reason = "every test binary uses its own part")]

pub mod target;
pub use system_tests::virtual_bus;
