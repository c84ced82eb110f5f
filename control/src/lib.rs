//! A PneuDrive board's behaviour without its hardware.
//!
//! Time, bytes and ADC readings are arguments; answers and valve drives are results. The same code
//! runs on the chip (`firmware/`), in the emulated chip, and as a native board on the simulated
//! bus, and whoever runs it makes the same calls:
//!
//! ```text
//!  every byte on the bus   -> Board::receive_byte(now, byte) -> ten bytes to send back to back,
//!                                                               or nothing
//!  damaged byte            -> Board::line_error(now)
//!  silence (unless bytes
//!  are stamped exactly)    -> Board::line_idle(now)
//!  every loop period       -> Board::control_step(now, four samples) -> four valve drives
//!                                                                    -> DirPwm -> pins
//! ```
//!
//! ```
//! use pneudrive_control::{AdcSample, Board, BoardConfig, DirPwm, Micros};
//! use pneudrive_protocol::{Address, Counts, Packet};
//!
//! let mut board = Board::new(BoardConfig::default(), Address::of_board(0))?;
//! // A board answers with the pressures of its last control step.
//! let samples = [AdcSample::from_reading(4 * 102); 4];
//! let drives = board.control_step(Micros::ZERO, samples);
//! assert_eq!(DirPwm::from(drives[0]).coil(), -255); // it vents for 2 s after power-up
//!
//! let request = Packet { address: Address::of_board(0), values: [Counts::ATMOSPHERE; 4] }.encode();
//! let answers: Vec<_> = request
//!     .iter()
//!     .enumerate()
//!     .filter_map(|(n, byte)| board.receive_byte(Micros::new(10 * n as u64), *byte))
//!     .collect();
//! assert_eq!(answers, [request]); // at 102 counts, as commanded
//! # Ok::<(), pneudrive_control::ConfigError>(())
//! ```
//!
//! What of its configuration a host can change, and how flash keeps it, is in [`BoardStart`] and
//! [`store`].
//!
//! Inside, a board is two halves, which firmware runs at two priorities: the [`BusPort`] and the
//! [`ControlLoop`]. The loop has the supervisor ([`BoardState`]) and per channel the sensor monitor
//! ([`SensorFault`]), the low-pass, the control law and the valve drive ([`ValveDrive`],
//! [`DirPwm`]): one file each.
//!
//! All arithmetic is on integers; pressures carry [`FRACTION_BITS`] bits behind the binary point.
//! There is no `unsafe`, no allocation and no panic path that bytes, samples or times could reach.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod agreement;
mod board;
mod channel;
mod chip_thermometer;
mod config;
mod control_loop;
mod damage;
mod desk;
mod drive;
mod filter;
mod i2c_sensors;
mod identity;
mod indicator;
mod law;
mod line_rate;
mod liveness;
mod pages;
mod parameters;
mod port;
mod port_updates;
mod responder;
mod sample;
mod sensor;
mod start;
mod status;
pub mod store;
mod supervisor;
mod time;
mod transducer;
pub mod update;

pub use board::Board;
pub use chip_thermometer::ChipThermometer;
pub use config::{BoardConfig, ConfigError};
pub use control_loop::{ControlLoop, Step};
pub use drive::{DirPwm, Direction, ValveDrive};
pub use i2c_sensors::{I2cSensors, Motion};
pub use identity::Identity;
pub use liveness::Liveness;
pub use parameters::ParameterSet;
pub use port::{Answer, BusPort, Orders, Report};
pub use sample::{AdcSample, FRACTION_BITS};
pub use sensor::SensorFault;
pub use start::BoardStart;
pub use status::{BoardStatus, ChannelStatus, ControlStatus, Counters};
pub use store::Stored;
pub use supervisor::BoardState;
pub use time::Micros;
pub use transducer::{Transducer, acceleration_steps, angular_rate_steps};
