//! The checked format: its bytes, frozen, and what its CRC finds.
//!
//! If a test of bytes in this file fails, do not change the test: the change that broke it cannot
//! be made.

use pneudrive_protocol::{
    Address, CheckedError, CheckedPacket, Counts, Direction, Packet, PacketError, Sequence,
};
use proptest::prelude::*;

fn checked(board: u8, sequence: u8, values: [u16; 4]) -> CheckedPacket {
    let values = values.map(|value| Counts::new(value).unwrap());
    CheckedPacket {
        packet: Packet { address: Address::of_board(board), values },
        sequence: Sequence::new(sequence),
    }
}

/// The 20 spare bits are written out in the comments as sequence number and CRC; the CRC was
/// computed with an independent implementation
/// (`crcmod.predefined.mkPredefinedCrcFun('crc-16-dnp')` in Python).
#[rustfmt::skip]
const FROZEN_REQUEST: [u8; 10] = [
    0xFF, // address, high byte
    0xFF, // address, low byte: board 0
    0x28, // 0, sequence 0101, CRC bit 15 = 0, value 0 high bits 00
    0x66, // value 0: 102
    0x6C, // 0, CRC bits 14 to 10 = 11011, value 1 high bits 00
    0xFF, // value 1: 255
    0x1A, // 0, CRC bits 9 to 5 = 00110, value 2 high bits 10
    0x00, // value 2: 512
    0x7B, // 0, CRC bits 4 to 0 = 11110, value 3 high bits 11; CRC = 0x6CDE
    0xFF, // value 3: 1023
];

#[rustfmt::skip]
const FROZEN_ANSWER: [u8; 10] = [
    0xFF, // address, high byte
    0xFC, // address, low byte: board 3
    0x7C, // 0, sequence 1111, CRC bit 15 = 1, value 0 high bits 00
    0x00, // value 0: 0
    0x50, // 0, CRC bits 14 to 10 = 10100, value 1 high bits 00
    0x01, // value 1: 1
    0x01, // 0, CRC bits 9 to 5 = 00000, value 2 high bits 01
    0xFF, // value 2: 511
    0x57, // 0, CRC bits 4 to 0 = 10101, value 3 high bits 11; CRC = 0xD015
    0x9A, // value 3: 922
];

/// The host leaves: four commands of 0 counts.
#[rustfmt::skip]
const FROZEN_LEAVE: [u8; 10] = [
    0xFF, // address, high byte
    0xFE, // address, low byte: board 1
    0x18, // 0, sequence 0011, CRC bit 15 = 0, value 0 high bits 00
    0x00, // value 0: 0
    0x6C, // 0, CRC bits 14 to 10 = 11011, value 1 high bits 00
    0x00, // value 1: 0
    0x78, // 0, CRC bits 9 to 5 = 11110, value 2 high bits 00
    0x00, // value 2: 0
    0x18, // 0, CRC bits 4 to 0 = 00110, value 3 high bits 00; CRC = 0x6FC6
    0x00, // value 3: 0
];

#[test]
fn the_host_leaves_board_1_with_sequence_3() {
    let leave = CheckedPacket::leave(Address::of_board(1), Sequence::new(3));
    assert_eq!(leave, checked(1, 3, [0; 4]));
    assert_eq!(leave.encode(Direction::Request), FROZEN_LEAVE);
    assert!(CheckedPacket::decode(&FROZEN_LEAVE, Direction::Request).unwrap().is_leave());
    for channel in 0..4 {
        let mut values = [0; 4];
        values[channel] = 1;
        assert!(!checked(1, 3, values).is_leave());
    }
}

#[test]
fn request_to_board_0_with_sequence_5() {
    let packet = checked(0, 5, [102, 255, 512, 1023]);
    let bytes = packet.encode(Direction::Request);
    assert_eq!(bytes, FROZEN_REQUEST);
    assert_eq!(CheckedPacket::decode(&bytes, Direction::Request), Ok(packet));
}

#[test]
fn answer_of_board_3_with_sequence_15() {
    let packet = checked(3, 15, [0, 1, 511, 922]);
    let bytes = packet.encode(Direction::Answer);
    assert_eq!(bytes, FROZEN_ANSWER);
    assert_eq!(CheckedPacket::decode(&bytes, Direction::Answer), Ok(packet));
}

#[test]
fn an_echoed_request_is_no_answer() {
    let bytes = checked(1, 3, [400; 4]).encode(Direction::Request);
    assert!(matches!(CheckedPacket::decode(&bytes, Direction::Answer), Err(CheckedError::Crc { .. })));
}

#[test]
fn an_unchecked_packet_is_no_checked_one() {
    let bytes = checked(1, 3, [400; 4]).packet.encode();
    assert!(matches!(
        CheckedPacket::decode(&bytes, Direction::Request),
        Err(CheckedError::Crc { got: 0, .. })
    ));
}

/// How a host finds out what kind of board it pings: an original board drops packets with values
/// above 1023.
#[test]
fn an_original_board_drops_checked_requests() {
    for sequence in 0..Sequence::MODULUS {
        let bytes = checked(0, sequence, [102; 4]).encode(Direction::Request);
        assert!(
            matches!(Packet::decode(&bytes), Err(PacketError::ValueOutOfRange { .. })),
            "sequence {sequence}"
        );
    }
}

/// The bits of ten bytes that a packet can carry information in: bit 15 of data words and the
/// address's high byte are fixed, and damage there is found without the CRC.
fn free_bits() -> Vec<u32> {
    (0..80).filter(|bit| *bit >= 8 && !(*bit >= 16 && bit % 16 == 0)).collect()
}

fn flip(bytes: u128, positions: &[u32]) -> [u8; 10] {
    let flipped = positions.iter().fold(bytes, |bytes, position| bytes ^ 1 << (79 - position));
    flipped.to_be_bytes()[6..].try_into().unwrap()
}

/// Hamming distance 6, proved: a CRC is linear, so which error patterns it misses does not depend
/// on the packet, and all 11 million patterns of one to five flipped bits are tried.
#[test]
fn every_error_of_up_to_five_bits_is_found() {
    let packet = checked(2, 9, [300, 301, 302, 303]);
    let bytes = packet.encode(Direction::Answer);
    let sent = bytes.iter().fold(0u128, |all, byte| all << 8 | u128::from(*byte));
    let free = free_bits();
    let syndrome = |positions: &[u32]| match CheckedPacket::decode(&flip(sent, positions), Direction::Answer)
    {
        Ok(_) => 0,
        Err(CheckedError::Crc { expected, got }) => expected ^ got,
        Err(form) => panic!("{positions:?}: {form}"),
    };
    let single: Vec<u16> = free.iter().map(|bit| syndrome(&[*bit])).collect();
    let n = single.len();
    // Linearity, on which the rest stands.
    assert_eq!(syndrome(&[free[3], free[20], free[50]]), single[3] ^ single[20] ^ single[50]);
    let mut smallest_missed = u32::MAX;
    for a in 0..n {
        smallest_missed = smallest_missed.min(if single[a] == 0 { 1 } else { u32::MAX });
        for b in a + 1..n {
            let ab = single[a] ^ single[b];
            smallest_missed = smallest_missed.min(if ab == 0 { 2 } else { u32::MAX });
            for c in b + 1..n {
                let abc = ab ^ single[c];
                smallest_missed = smallest_missed.min(if abc == 0 { 3 } else { u32::MAX });
                for d in c + 1..n {
                    let abcd = abc ^ single[d];
                    smallest_missed = smallest_missed.min(if abcd == 0 { 4 } else { u32::MAX });
                    for last in &single[d + 1..] {
                        if abcd == *last {
                            smallest_missed = smallest_missed.min(5);
                        }
                    }
                }
            }
        }
    }
    assert_eq!(smallest_missed, u32::MAX, "an error of {smallest_missed} bits goes undetected");
}

proptest! {
    #[test]
    fn packets_come_back(board in any::<u8>(), sequence in 0u8..16, values in [0..=1023u16, 0..=1023, 0..=1023, 0..=1023]) {
        let packet = checked(board, sequence, values);
        for direction in [Direction::Request, Direction::Answer] {
            let bytes = packet.encode(direction);
            prop_assert_eq!(CheckedPacket::decode(&bytes, direction), Ok(packet));
            prop_assert_eq!(CheckedPacket::decode_either(&bytes), Ok((packet, direction)));
            // No data word can be an address.
            prop_assert!(bytes[2..].chunks(2).all(|word| word[0] < 0x80));
        }
    }

    #[test]
    fn any_bytes_never_panic(bytes in any::<[u8; 10]>()) {
        let _ = CheckedPacket::decode(&bytes, Direction::Request);
    }
}
