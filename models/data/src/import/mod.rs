//! Foreign CSV files into the measured-data format: columns mapped, units converted.

mod convert;
mod error;
mod mapping;
mod unit;

pub use convert::{Foreign, Imported, TimeSource, convert};
pub use error::{ImportError, OutOfRange};
pub use mapping::Mapping;
pub use unit::Unit;
