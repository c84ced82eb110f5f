//! The bytes on the wire, frozen. Boards in the field and the original's hosts speak them.
//!
//! If a test in this file fails, do not change the test: the change that broke it cannot be made.

use pneudrive_protocol::{Address, Counts, Packet, PacketError};

fn packet(board: u8, values: [u16; 4]) -> Packet {
    Packet { address: Address::of_board(board), values: values.map(|value| Counts::new(value).unwrap()) }
}

fn assert_wire(packet: Packet, bytes: [u8; 10]) {
    assert_eq!(packet.encode(), bytes);
    assert_eq!(Packet::decode(&bytes), Ok(packet));
}

#[test]
fn request_to_board_0() {
    assert_wire(
        packet(0, [102, 255, 256, 1023]),
        [
            0xFF, // address, high byte: always 0xFF
            0xFF, // address, low byte: 0xFF - board 0
            0x00, // channel 0, high byte
            0x66, // channel 0, low byte: 102 counts, 0 kPa
            0x00, // channel 1, high byte
            0xFF, // channel 1, low byte: 255 counts; a low byte may be 0xFF
            0x01, // channel 2, high byte: 256 counts
            0x00, // channel 2, low byte
            0x03, // channel 3, high byte: 1023 counts, the largest value
            0xFF, // channel 3, low byte
        ],
    );
}

#[test]
fn answer_of_board_3() {
    assert_wire(
        packet(3, [0, 1, 511, 922]),
        [
            0xFF, // address, high byte
            0xFC, // address, low byte: 0xFF - board 3
            0x00, // channel 0, high byte
            0x00, // channel 0, low byte: 0 counts
            0x00, // channel 1, high byte
            0x01, // channel 1, low byte: 1 count
            0x01, // channel 2, high byte
            0xFF, // channel 2, low byte: 511 counts
            0x03, // channel 3, high byte
            0x9A, // channel 3, low byte: 922 counts, full scale
        ],
    );
}

#[test]
fn request_to_the_last_address() {
    assert_wire(
        packet(255, [0; 4]),
        [
            0xFF, // address, high byte
            0x00, // address, low byte: 0xFF - board 255
            0x00, 0x00, // channel 0
            0x00, 0x00, // channel 1
            0x00, 0x00, // channel 2
            0x00, 0x00, // channel 3
        ],
    );
}

#[test]
fn ten_bytes_that_are_no_packet() {
    let mut bytes = packet(0, [0; 4]).encode();
    bytes[0] = 0xFE;
    assert_eq!(Packet::decode(&bytes), Err(PacketError::NotAnAddress { word: 0xFEFF }));
    let mut bytes = packet(0, [0; 4]).encode();
    bytes[6] = 0x04;
    assert_eq!(Packet::decode(&bytes), Err(PacketError::ValueOutOfRange { index: 2, word: 0x0400 }));
}
