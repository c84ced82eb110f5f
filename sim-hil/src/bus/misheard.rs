//! What a receiver makes of a character that is sent at another line rate than its own.

use super::wire::InFlight;
use super::{Heard, Line};

/// Gives `take` what whoever listens at `line` hears of a character: itself at the same rate.
///
/// At another rate it is what a UART samples: from a falling edge on it looks at the middle of each
/// bit, and flags the byte if the stop bit is low. Each character is looked at by itself, with an
/// idle line behind it. So most of it comes flagged, and some as a byte that nobody sent.
pub(super) fn heard_at(line: &Line, flight: &InFlight, mut take: impl FnMut(Heard)) {
    if line.understands(&flight.line) {
        return take(flight.heard);
    }
    let (bit, own) = (flight.line.bit_ps(), line.bit_ps());
    let is_high = |at_ps: u64| match at_ps / bit {
        0 => false,
        n @ 1..=8 => flight.heard.byte >> (n - 1) & 1 == 1,
        _ => true,
    };
    let mut from_ps = 0;
    for edge_ps in (0..=8).map(|n| n * bit) {
        let falls = !is_high(edge_ps) && edge_ps.checked_sub(1).is_none_or(is_high);
        // A low that is over in the middle of the start bit is none.
        if !falls || edge_ps < from_ps || is_high(edge_ps + own / 2) {
            continue;
        }
        let sample = |n: u64| is_high(edge_ps + own * (2 * n + 1) / 2);
        let byte = (1..=8).fold(0, |byte, n| byte | u8::from(sample(n)) << (n - 1));
        take(Heard { byte, damaged: flight.heard.damaged || !sample(9) });
        from_ps = edge_ps + own * 19 / 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Baud;

    fn line(baud: u32) -> Line {
        Line::at_baud(Baud::ORIGINAL).unwrap().at_rate(Some(Baud::new(baud).unwrap()))
    }

    fn heard(byte: u8, from: u32, to: u32) -> Vec<(u8, bool)> {
        let heard = Heard { byte, damaged: false };
        let line_of = line(from);
        let flight = InFlight::of(crate::bus::Talker::Host, line_of, 0, heard);
        let mut all = Vec::new();
        heard_at(&line(to), &flight, |heard| all.push((heard.byte, heard.damaged)));
        all
    }

    #[test]
    fn who_listens_at_the_rate_hears_the_byte() {
        for byte in 0..=255 {
            assert_eq!(heard(byte, 3_000_000, 3_000_000), [(byte, false)]);
            // A chip's divisors make 2,994,012 baud of 3 Mbaud.
            assert_eq!(heard(byte, 3_000_000, 2_994_012), [(byte, false)]);
        }
    }

    /// By hand: at 3 Mbaud each bit of 1 Mbaud is seen three times.
    #[test]
    fn who_listens_three_times_as_fast_hears_pieces() {
        // 000 then ones: start bit, 0 0, six ones, stop.
        assert_eq!(heard(0xFF, 1_000_000, 3_000_000), [(0xFC, false)]);
        // Low for 27 of its bits: one flagged byte, and no edge after it.
        assert_eq!(heard(0x00, 1_000_000, 3_000_000), [(0x00, true)]);
        // 0 10101010: start and low, and then three lows of one bit each, seen as bytes with a high
        // stop bit or not.
        assert_eq!(heard(0x55, 1_000_000, 3_000_000).len(), 3);
    }

    #[test]
    fn who_listens_a_third_as_fast_hears_one_byte_or_none() {
        // Its start bit covers start, 1 and 1: high in the middle.
        assert_eq!(heard(0xFF, 3_000_000, 1_000_000), []);
        // Low for nine bits: start and two zeros.
        assert_eq!(heard(0x00, 3_000_000, 1_000_000), [(0xFC, false)]);
    }
}
