//! Virtual PneuDrive boards on a virtual RS-485 bus, with chambers behind them.

pub mod plant;
pub mod record;
