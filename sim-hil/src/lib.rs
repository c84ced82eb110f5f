//! Virtual PneuDrive boards on a virtual RS-485 bus, with chambers behind them.

pub mod board;
pub mod bus;
pub mod fault;
pub mod plant;
pub mod pty;
pub mod record;
pub mod rig;
