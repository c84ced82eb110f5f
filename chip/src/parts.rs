//! Parts on an I2C bus: what one is, and two that are emulated from their datasheets.

mod ads1115;
mod bmi323;

#[cfg(test)]
mod tests;

use std::any::Any;
use std::fmt;

use crate::ticks::Ticks;

pub use ads1115::Ads1115;
pub use bmi323::Bmi323;

/// A part (a "target") on an I2C bus, byte by byte. [`Chip::attach_i2c`](crate::Chip::attach_i2c)
/// gives it its address.
///
/// Times are those at which the byte ends on the bus. A part never sees a byte that is not for it.
pub trait I2cPart: Any + fmt::Debug + Send + Sync + CloneI2cPart {
    /// A START or repeated START with this part's address, for reading or for writing. Gives
    /// whether it acknowledges.
    fn start(&mut self, now: Ticks, read: bool) -> bool;

    /// A byte is written to it. Gives whether it acknowledges.
    fn write(&mut self, now: Ticks, byte: u8) -> bool;

    /// The byte that it sends next.
    fn read(&mut self, now: Ticks) -> u8;

    /// The transfer ends.
    fn stop(&mut self, now: Ticks) {
        let _ = now;
    }
}

/// What lets a chip with its parts be cloned. Every [`I2cPart`] that is [`Clone`] has it.
pub trait CloneI2cPart {
    /// The same part once more.
    fn clone_part(&self) -> Box<dyn I2cPart>;
}

impl<P: I2cPart + Clone> CloneI2cPart for P {
    fn clone_part(&self) -> Box<dyn I2cPart> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn I2cPart> {
    fn clone(&self) -> Box<dyn I2cPart> {
        self.as_ref().clone_part()
    }
}
