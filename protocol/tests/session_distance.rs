//! Hamming distance 6 in a session: every error of up to five bits is found, also one that moves
//! the request to another round.
//!
//! A CRC is linear, so which errors are missed depends on the packet only by what a board expects:
//! the round that it takes the sequence to be of. All sequences, all windows and all 15 steps
//! between rounds are tried, each with all patterns of up to five bits.

use pneudrive_protocol::{
    Address, CheckedError, CheckedPacket, Counts, Direction, Packet, RequestNumber, Sequence, Session,
};
use std::collections::{BTreeMap, BTreeSet};

fn checked() -> CheckedPacket {
    let values = [300, 301, 302, 303].map(Counts::saturating);
    CheckedPacket { packet: Packet { address: Address::of_board(2), values }, sequence: Sequence::new(9) }
}

/// The CRC that is missing after these bits, counted from the first of the wire, were flipped.
fn syndrome(bits: &[usize]) -> Option<u16> {
    let mut bytes = checked().encode(Direction::Request);
    bits.iter().for_each(|bit| bytes[bit / 8] ^= 0x80 >> (bit % 8));
    match CheckedPacket::decode(&bytes, Direction::Request) {
        Ok(_) => Some(0),
        Err(CheckedError::Crc { expected, got }) => Some(expected ^ got),
        Err(CheckedError::Form(_)) => None,
    }
}

/// Bits 3 to 0 of the sequence stand in the first data word, bits 14 to 11.
const SEQUENCE_BITS: [usize; 4] = [17, 18, 19, 20];

/// Syndromes of single bits: of the sequence's four, highest first, and of all others.
fn single_bits() -> ([u16; 4], Vec<u16>) {
    let others = (8..80).filter(|bit| !SEQUENCE_BITS.contains(bit)).filter_map(|bit| syndrome(&[bit]));
    (SEQUENCE_BITS.map(|bit| syndrome(&[bit]).unwrap()), others.collect())
}

/// Which flips of the sequence make a board that stands at some number expect another round than
/// the host's, and by what the CRCs of the two differ.
fn round_confusions() -> BTreeSet<(u8, u16)> {
    let session = Session::new(Address::of_board(2), 1);
    let mut confusions = BTreeSet::new();
    // Round 2^15 - 1 to 0 takes the highest step as 2^14 - 1 to 2^14 does; so all steps occur up to
    // there.
    let ends = (0..15).map(|step| (1 << step) * 16).chain([RequestNumber::MODULUS]);
    for last in ends.flat_map(|end: u32| (end - 16..end).map(RequestNumber::new)) {
        for ahead in 1..=u32::from(RequestNumber::WINDOW) {
            let sent = RequestNumber::new(last.get() + ahead);
            for flips in 1..16 {
                let heard = Sequence::new(sent.sequence().get() ^ flips);
                let Some(taken_for) = last.following(heard) else { continue };
                let difference =
                    session.seal(sent).crc_difference() ^ session.seal(taken_for).crc_difference();
                if difference != 0 {
                    confusions.insert((flips, difference));
                }
            }
        }
    }
    confusions
}

/// For every syndrome the fewest flips, up to five, of bits that are not the sequence's.
fn fewest_flips(singles: &[u16]) -> BTreeMap<u16, usize> {
    let mut fewest = vec![usize::MAX; 1 << 16];
    fewest[0] = 0;
    let mut sums = vec![(0_u16, 0_usize)];
    for flips in 1..=4 {
        let mut next = Vec::new();
        for &(sum, from) in &sums {
            for (at, single) in singles.iter().enumerate().skip(from) {
                next.push((sum ^ single, at + 1));
            }
        }
        next.iter().for_each(|&(sum, _)| {
            let seen = &mut fewest[usize::from(sum)];
            *seen = (*seen).min(flips);
        });
        sums = next;
    }
    (0..=u16::MAX).zip(fewest).filter(|&(_, flips)| flips != usize::MAX).collect()
}

#[test]
fn an_error_of_up_to_five_bits_never_moves_a_request_to_another_round() {
    let (sequence, others) = single_bits();
    assert_eq!(others.len(), 64);
    assert_eq!(
        syndrome(&[SEQUENCE_BITS[0], 9, 70]).unwrap(),
        sequence[0] ^ syndrome(&[9]).unwrap() ^ syndrome(&[70]).unwrap(),
        "linear"
    );
    let fewest = fewest_flips(&others);
    let confusions = round_confusions();
    let steps: BTreeSet<u16> = confusions.iter().map(|&(_, difference)| difference).collect();
    assert_eq!(steps.len(), 15, "all steps are tried");
    for (flips, difference) in confusions {
        let of_sequence =
            (0..4).filter(|bit| flips >> (3 - bit) & 1 == 1).fold(difference, |sum, bit| sum ^ sequence[bit]);
        let errors = flips.count_ones() as usize + fewest.get(&of_sequence).copied().unwrap_or(6);
        assert!(errors >= 6, "{errors} flipped bits: sequence by {flips:04b}, CRC by {difference:04X}");
    }
}

/// An answer is expected with one number only, so what is tried for packets without a session holds
/// for it; and so it does for requests that stay in their round.
#[test]
fn a_seal_changes_nothing_but_the_crc_and_by_the_same_for_all_packets() {
    let session = Session::new(Address::of_board(2), 77);
    for number in [1, 9, 4_321].map(RequestNumber::new) {
        let seal = session.seal(number);
        let plain = CheckedPacket { sequence: number.sequence(), ..checked() };
        for direction in [Direction::Request, Direction::Answer] {
            let sealed = plain.encode_sealed(direction, seal);
            match CheckedPacket::decode(&sealed, direction) {
                Err(CheckedError::Crc { expected, got }) => {
                    assert_eq!(expected ^ got, seal.crc_difference());
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
