//! Boards made of nothing but the protocol, for tests of the host alone. (System tests use the
//! simulator.)

pub mod pty;
pub mod virtual_line;

use pneudrive_protocol::{Address, CHANNELS, Counts, Packet};

/// Four equal counts.
pub fn counts(value: u16) -> [Counts; CHANNELS] {
    [Counts::new(value).unwrap(); CHANNELS]
}

/// Bytes of `board`'s answer with four equal pressures.
pub fn answer(board: u8, pressure: u16) -> Vec<u8> {
    Packet { address: Address::of_board(board), values: counts(pressure) }.encode().to_vec()
}
