use crate::PACKET_LEN;
use core::num::NonZeroU32;
use thiserror::Error;

/// A line that was silent for this many characters starts a new frame.
///
/// Longer than any pause inside a request or answer that is written at once (a UART sends its FIFO
/// back to back), shorter than the silence after a request that nobody answers.
pub const IDLE_GAP_CHARACTERS: u16 = 3;

/// Bits of a character: start, eight data, stop.
pub const BITS_PER_CHARACTER: u32 = 10;

/// A line rate, and how long things take at it. All times are in ns and rounded up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Baud(NonZeroU32);

/// A line rate outside what the bus can be run at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{value} baud is outside {min} to {max} baud", min = Baud::MIN, max = Baud::MAX)]
pub struct BaudError {
    /// The rate that was refused.
    pub value: u32,
}

impl Baud {
    /// Slowest rate accepted, bit/s.
    pub const MIN: u32 = 1_200;
    /// Fastest rate accepted, bit/s: the RP2040's UART at 125 MHz ends at 125/16 Mbaud (datasheet
    /// 4.2.7.1).
    pub const MAX: u32 = 7_812_500;
    /// The original's 1 Mbaud.
    pub const ORIGINAL: Self = Self(NonZeroU32::new(1_000_000).unwrap());
    /// Twice the original's: what host and boards can agree on
    /// ([`LineRate`](crate::pages::LineRate)).
    pub const TWO_MBAUD: Self = Self(NonZeroU32::new(2_000_000).unwrap());
    /// Three times the original's, likewise.
    pub const THREE_MBAUD: Self = Self(NonZeroU32::new(3_000_000).unwrap());

    /// Refuses rates outside [`Baud::MIN`] to [`Baud::MAX`].
    pub const fn new(value: u32) -> Result<Self, BaudError> {
        match NonZeroU32::new(value) {
            Some(rate) if value >= Self::MIN && value <= Self::MAX => Ok(Self(rate)),
            _ => Err(BaudError { value }),
        }
    }

    /// Bits per second.
    pub const fn get(self) -> u32 {
        self.0.get()
    }

    /// Time of `characters` back to back, ns.
    pub const fn characters_ns(self, characters: u16) -> u64 {
        let bits = characters as u64 * BITS_PER_CHARACTER as u64;
        (bits * 1_000_000_000).div_ceil(self.0.get() as u64)
    }

    /// Time of one packet, ns: 100 us at 1 Mbaud.
    pub const fn packet_ns(self) -> u64 {
        self.characters_ns(PACKET_LEN as u16)
    }

    /// Time of a request and its answer without any pause, ns: 200 us at 1 Mbaud.
    pub const fn exchange_ns(self) -> u64 {
        2 * self.packet_ns()
    }

    /// The wire's limit of the polling rate with `boards` on the bus, Hz: 5000/n at 1 Mbaud.
    pub fn cycle_limit_hz(self, boards: u32) -> f64 {
        1e9 / (self.exchange_ns() as f64 * f64::from(boards))
    }

    /// Silence that starts a new frame, ns: [`IDLE_GAP_CHARACTERS`].
    pub const fn idle_gap_ns(self) -> u64 {
        self.characters_ns(IDLE_GAP_CHARACTERS)
    }
}

impl Default for Baud {
    fn default() -> Self {
        Self::ORIGINAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_at_one_megabaud() {
        let baud = Baud::ORIGINAL;
        assert_eq!(baud.characters_ns(1), 10_000);
        assert_eq!(baud.packet_ns(), 100_000);
        assert_eq!(baud.exchange_ns(), 200_000);
        assert_eq!(baud.idle_gap_ns(), 30_000);
        let limits = [1, 2, 3, 4].map(|boards| baud.cycle_limit_hz(boards));
        assert_eq!(limits, [5000.0, 2500.0, 1e9 / 600_000.0, 1250.0]);
    }

    #[test]
    fn times_are_rounded_up() {
        // 10 bits at 115,200 baud are 86,805.55 ns.
        assert_eq!(Baud::new(115_200).unwrap().characters_ns(1), 86_806);
        // Neither the largest count nor the slowest rate overflows.
        assert_eq!(Baud::new(Baud::MIN).unwrap().characters_ns(u16::MAX), 546_125_000_000);
    }

    #[test]
    fn rates_outside_the_range_are_refused() {
        for value in [0, 1_199, 7_812_501, u32::MAX] {
            assert_eq!(Baud::new(value), Err(BaudError { value }));
        }
        let error = Baud::new(300).unwrap_err();
        assert_eq!(std::format!("{error}"), "300 baud is outside 1200 to 7812500 baud");
    }
}
