//! The virtual RS-485 pair: byte-accurate, in virtual time, and stricter than the wire.
//!
//! Time is an argument everywhere, in ns since the rig was switched on. [`Bus`] is a discrete-event
//! simulation: it jumps from one start bit, stop bit, control step or fault to the next, so that
//! idle minutes cost next to nothing.
//!
//! - [`Line`]: how long bits last, the 555's pulse, the least turnaround.
//! - [`BusNode`]: what a board looks like to the bus; native boards and emulated chips implement
//!   it. [`Air`] is what a board has on its other side.
//! - `Wire` (private): characters on their way; what overlaps is damaged.
//! - `Referee` (private): counts into [`BusCounters`] what a healthy bus never shows; in strict
//!   mode it panics.
//!
//! Parties can be at different line rates: who listens at another rate than is spoken at hears what
//! its receiver makes of the bits.
//!
//! A character is delivered to every other party at the end of its stop bit. Half duplex: a board
//! does not hear itself, and the host hears its own bytes only where the `echo` fault says so.

mod character;
mod counters;
mod event_loop;
mod host;
mod line;
mod misheard;
mod node;
mod referee;
mod wire;

pub use character::{Character, Heard, Talker};
pub use counters::BusCounters;
pub use event_loop::Bus;
pub use host::HostByte;
pub use line::Line;
pub use node::{Air, BusNode, JointNow};
