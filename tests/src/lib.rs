//! End-to-end tests of PneuDrive.
//!
//! The tests are in `tests/`; here is what several of them share.

pub mod blind;
pub mod cable;
pub mod chip_bench;
pub mod fault_table;
pub mod firmware;
pub mod regulator;
pub mod self_check;
pub mod session_host;
pub mod take;
pub mod update_bench;
pub mod virtual_bus;
