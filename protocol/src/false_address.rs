//! How a bus with boards of the original kind is kept free of addresses that nobody means.
//!
//! A board of the original kind looks for its two address bytes anywhere in the stream of bytes,
//! with no regard to where packets begin. Only one pair of bytes can look like an address where
//! none is meant: the last byte of a packet, if it is 0xFF, and the first byte of the next packet,
//! which is 0xFF always. `FF FF` is board 0's address, so board 0 alone is at risk:
//!
//! - inside a packet a word's high byte is at most 0x7F, so no pair there is an address;
//! - across two packets the second byte is 0xFF, and the other boards' addresses end in 0xFE and
//!   less.
//!
//! Board 0 then takes the next eight bytes for its commands, drops them because they exceed 1023,
//! and answers all the same. Two rules keep the pair off the wire:
//!
//! 1. No request ends in 0xFF, because an answer follows it ([`without_false_address`]). Requests
//!    to board 0 are no exception: it does not hear its own answer, so for board 0 the next request
//!    follows.
//! 2. Where the last byte on the wire was 0xFF or is not known, a byte 0x00 goes before the request
//!    ([`needs_guard`]): an answer may end in 0xFF, and a host cannot choose what it ends in.
//!
//! The byte stands alone, not in one run with its request: a host whose line driver is enabled by
//! the boards' 555 circuit would have the driver switched off inside a run of eleven bytes, or on
//! again into the answer. [`guard_pause_ns`] is how long the request has to wait.

use crate::pulse::{Parts, pulse, resistor_for};
use crate::{Address, Baud, CHANNELS, Counts};

/// The byte that is sent before a request where the byte before could make a false address.
pub const GUARD: u8 = 0x00;

/// Whether a request needs [`GUARD`] before it when `last` was the last byte on the wire (`None`:
/// not known) and board 0 may be of the original kind.
pub const fn needs_guard(last: Option<u8>) -> bool {
    matches!(last, None | Some(Address::HIGH_BYTE))
}

/// The commands nearest to `commands` whose request does not end in 0xFF: that of channel 3 is one
/// count (0.84 kPa) lower if it is 255, 511, 767 or 1023. The same in both packet formats, because
/// the low byte of a data word is that of its value.
pub const fn without_false_address(mut commands: [Counts; CHANNELS]) -> [Counts; CHANNELS] {
    let last = &mut commands[CHANNELS - 1];
    if last.get() as u8 == Address::HIGH_BYTE {
        *last = Counts::saturating(last.get() - 1);
    }
    commands
}

/// From the start of [`GUARD`] to that of the request, ns: until the longest pulse of a 555 that
/// the guard has triggered is over, and three characters more.
pub fn guard_pause_ns(baud: Baud) -> u64 {
    let parts = Parts::ORIGINAL;
    let longest_ns = match resistor_for(baud, parts) {
        Ok(ohm) => pulse(ohm, parts).longest_ns,
        // No such circuit exists at this rate; as long as it would last.
        Err(_) => baud.packet_ns() + baud.packet_ns() / 4,
    };
    longest_ns + baud.idle_gap_ns()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guard_waits_for_the_longest_pulse() {
        assert_eq!(guard_pause_ns(Baud::ORIGINAL), 113_854 + 30_000);
    }

    #[test]
    fn only_four_set_points_of_channel_3_change() {
        let mut changed = std::vec::Vec::new();
        for value in 0..=1023 {
            let counts = Counts::saturating(value);
            let sent = without_false_address([counts; CHANNELS]);
            assert_eq!(sent[..3], [counts; 3]);
            if sent[3] != counts {
                assert_eq!(sent[3].get() + 1, value);
                changed.push(value);
            }
        }
        assert_eq!(changed, [255, 511, 767, 1023]);
    }
}
