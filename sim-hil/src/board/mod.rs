//! Boards on the bus, and the air behind them.
//!
//! [`NativeBoard`] runs the control crate itself; [`ChipBoard`] runs the firmware's ELF on an
//! emulated RP2040; [`OriginalBoard`] behaves as the original's firmware does, with its faults;
//! [`PlantAir`] puts the truth plant behind the sensors and valves of either.

mod air;
mod chip;
mod chip_parts;
mod i2c_parts;
mod i2c_world;
mod memory_flash;
mod native;
mod original;
mod pin_map;
mod turnaround;

pub use air::PlantAir;
pub use chip::ChipBoard;
pub use i2c_world::I2cConfig;
pub use native::{NativeBoard, NativeBoardConfig};
pub use original::OriginalBoard;
pub use turnaround::Turnaround;
