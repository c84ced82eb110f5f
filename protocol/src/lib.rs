//! PneuDrive's bus, as pure functions of bytes and numbers.
//!
//! A host and up to four boards (256 addresses exist) share one half-duplex RS-485 pair at 1 Mbaud
//! 8N1. The host sends a request to one board, that board answers, and nobody else speaks. Request
//! and answer have the same form:
//!
//! ```text
//!  byte   0    1    2    3    4    5    6    7    8    9
//!       +----+----+----+----+----+----+----+----+----+----+
//!       | address | value 0 | value 1 | value 2 | value 3 |     five big-endian 16-bit words
//!       +----+----+----+----+----+----+----+----+----+----+
//!        0xFFFF-n    0..=1023 ADC counts of a pressure sensor
//! ```
//!
//! - [`Address`], [`Counts`], [`Packet`]: what is on the wire. The bytes are frozen by
//!   `tests/wire_format.rs`.
//! - [`CheckedPacket`]: the same words with a sequence number and a CRC in their spare bits.
//! - [`Session`], [`RequestNumber`]: what keeps a checked request from being obeyed twice, or by
//!   another board.
//! - [`pages`]: what a board can be asked besides its pressures, in the same ten bytes.
//! - [`program`]: a board's program, as an update over the bus brings it.
//! - [`SensorScale`]: counts to kPa and back; what cannot be commanded is an error that names the
//!   value.
//! - [`RequestDecoder`] (board) and [`AnswerDecoder`] (host): find packets in a stream of bytes and
//!   keep alignment; [`FrameFinder`] does it for anybody who just listens.
//! - [`false_address`]: what a host does so that boards of the original kind do not misread it.
//! - [`Baud`]: how long characters, packets and exchanges take.
//! - [`pulse`]: the 555 timer that enables a board's line driver.
//!
//! Nothing here reads a clock, allocates, or does floating-point arithmetic on a board's path.
//! The crate is `no_std` and has no `unsafe`.
#![no_std]
#![forbid(unsafe_code)]

// The example there runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
extern crate std;

mod address;
mod answer_decoder;
mod baud;
mod checked;
mod counts;
pub mod false_address;
mod frame;
mod packet;
pub mod pages;
pub mod program;
pub mod pulse;
mod request_decoder;
mod scale;
mod sequence;
mod session;
mod spare_bits;

pub use address::Address;
pub use answer_decoder::{AnswerDecoder, Echo, Heard};
pub use baud::{BITS_PER_CHARACTER, Baud, BaudError, IDLE_GAP_CHARACTERS};
pub use checked::{CheckedError, CheckedPacket, Direction};
pub use counts::{Counts, CountsError};
pub use frame::{Frame, FrameFinder, FrameStatistics};
pub use packet::{CHANNELS, PACKET_LEN, Packet, PacketError};
pub use pages::{PageAnswer, PageRequest};
pub use request_decoder::{Asked, PacketFormat, Request, RequestDecoder};
pub use scale::{PressureError, ScaleError, SensorScale};
pub use sequence::Sequence;
pub use session::{RequestNumber, Seal, Session};
