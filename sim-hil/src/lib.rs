//! Virtual PneuDrive boards on a virtual RS-485 bus, with chambers behind them.
//!
//! This is software-in-the-loop simulation, although the folder is called `sim-hil`: boards run the
//! control crate natively, or the firmware's ELF on an emulated chip, and no hardware is in the
//! loop.
//!
//! ```text
//!   any client                                              record: files without a bus
//!       | bytes                                                        |
//!      pty ---- fault ---- bus ---- board ---------- plant ------------+
//!    wall clock          virtual time, ns           virtual time, ns
//! ```
//!
//! - [`bus`]: the half-duplex pair in virtual bit time, stricter than the wire, and what a board is
//!   to it.
//! - [`board`]: boards that run the control crate natively; the plant as their air.
//! - [`fault`]: what goes wrong between host and boards, by name, seeded and counted.
//! - [`plant`]: the truth plant, finer than the models that are fitted to it.
//! - [`rig`]: all of these together, for tests in virtual time.
//! - [`pty`]: a rig behind a pseudo-terminal, paced to the wall clock; the only module that reads
//!   one.
//! - [`record`]: recordings of the plant without a bus.
//! - [`cli`]: the command line of `pneudrive-sim`.

pub mod board;
pub mod bus;
pub mod cli;
pub mod fault;
pub mod pty;
pub mod record;
pub mod rig;

pub use pneudrive_truth as plant;
