//! Bus master for PneuDrive boards.
//!
//! The host speaks first on the bus, one board at a time: it sends four commands and gets four
//! pressures back. Modules, from the wire up:
//!
//! - [`mod@line`]: bytes and time. [`SerialPort`](line::SerialPort) is the real thing; tests bring
//!   their own, in virtual time.
//! - [`bus`]: one exchange with one board, its errors, resynchronisation after them, echo.
//! - [`real_time`]: scheduling of the bus thread on a machine that has other things to do.
//! - [`poller`]: all boards in turn, at a rate or as fast as possible, on a thread of its own.
//! - [`notices`]: what happens in a run, in sentences.
//! - [`statistics`]: what a run was like: loop rate, cycle times, losses.
//! - [`program_file`]: a board's program, for updates over the bus.
//! - [`replay`]: a recording in the views of a run, without a bus.
//! - [`Calibration`]: what the counts of every channel mean.
//! - `rig` (feature): limits and calibration from the rig file.
//! - `check` (feature): a self-test of boards, what
//!   [`pneudrive-check`](../pneudrive_check/index.html) plans.
//!
//! Crates of their own: [`pneudrive-record`](../pneudrive_record/index.html), measurements to a
//! file and set points from one; [`pneudrive-host-cli`](../pneudrive_host_cli/index.html), the
//! program `pneudrive-host`.
//!
//! ```no_run
//! use pneudrive_host::bus::{Bus, BusOptions};
//! use pneudrive_host::pneudrive_protocol::SensorScale;
//!
//! let scale = SensorScale::ORIGINAL;
//! let mut bus = Bus::open("/dev/ttyUSB0", BusOptions::default())?;
//! bus.ping(0)?;
//! let answer = bus.exchange(0, [scale.counts(100.0)?; 4])?;
//! println!("{:.1} kPa", scale.kpa(answer.pressures[0]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything blocks, nothing is async: one thread has nothing else to do than the bus.
//!
//! Durations are [`Duration`](std::time::Duration); those of more than 73 years count as 73 years.
//! Time stamps are integers: ns on the clock of the bus's [`Line`](line::Line), under names that
//! end in `_ns`.
#![forbid(unsafe_code)]

pub mod bus;
mod calibration;
#[cfg(feature = "check")]
pub mod check;
pub mod line;
pub mod notices;
pub mod poller;
pub mod program_file;
pub mod real_time;
pub mod replay;
#[cfg(feature = "rig")]
pub mod rig;
pub mod statistics;
mod time;
mod unix_time;

pub use calibration::Calibration;
/// Packets, addresses, counts and scales.
pub use pneudrive_protocol;
