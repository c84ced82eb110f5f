//! Boards on the bus, and the air behind them.
//!
//! [`NativeBoard`] runs the control crate itself; [`PlantAir`] puts the truth plant behind its sensors and valves.

mod air;
mod native;
mod turnaround;

pub use air::PlantAir;
pub use native::{NativeBoard, NativeBoardConfig};
pub use turnaround::Turnaround;
