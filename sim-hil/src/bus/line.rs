use pneudrive_protocol::pulse::{Parts, Pulse, PulseError, pulse, resistor_for};
use pneudrive_protocol::{BITS_PER_CHARACTER, Baud, IDLE_GAP_CHARACTERS};

/// How long bits last on the virtual wire, and what the boards' line drivers allow. Times in ns of
/// virtual time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    bits_per_second: u64,
    pulse: Pulse,
    /// Silence that must lie between the request's last stop bit and an answer's first start bit,
    /// ns.
    pub min_turnaround_ns: u64,
}

impl Line {
    /// Bits per second of a wire that takes no time to speak of.
    const INSTANT: u64 = 1_000_000_000;

    /// The host's adapter must have let go of the pair before a board drives it. The driver disable
    /// times in datasheets of 1 Mbaud transceivers stay below 1 us.
    pub const MIN_TURNAROUND_NS: u64 = 1_000;

    /// A wire of this line rate; the boards' 555 has the smallest resistor that covers a packet.
    ///
    /// # Errors
    /// No resistor gives the pulse ([`PulseError`]).
    pub fn at_baud(baud: Baud) -> Result<Self, PulseError> {
        let parts = Parts::ORIGINAL;
        Ok(Self {
            bits_per_second: u64::from(baud.get()),
            pulse: pulse(resistor_for(baud, parts)?, parts),
            min_turnaround_ns: Self::MIN_TURNAROUND_NS,
        })
    }

    /// A wire that takes no time to speak of: 1 ns a bit, 0.2 us an exchange. For
    /// `--timing instant`; no 555 can be too short for it and no turnaround too quick.
    pub fn instant() -> Self {
        Self { bits_per_second: Self::INSTANT, pulse: pulse(976, Parts::ORIGINAL), min_turnaround_ns: 0 }
    }

    /// How a party that has gone to another line rate sees this wire; `None` has not. A wire that
    /// takes no time takes none at any rate.
    #[must_use]
    pub fn at_rate(&self, baud: Option<Baud>) -> Self {
        match baud {
            Some(baud) if self.bits_per_second != Self::INSTANT => {
                Self { bits_per_second: u64::from(baud.get()), ..*self }
            }
            _ => *self,
        }
    }

    /// Whether who listens at this rate understands who speaks at the other: 8N1 bears 2 % between
    /// the two.
    pub fn understands(&self, other: &Self) -> bool {
        self.bits_per_second.abs_diff(other.bits_per_second) <= self.bits_per_second / 50
    }

    /// Time of `characters` back to back, ns, rounded up.
    ///
    /// The n-th start bit of a burst lies at `characters_ns(n)` after the first, so rounding never
    /// adds up.
    pub fn characters_ns(&self, characters: u64) -> u64 {
        (characters * u64::from(BITS_PER_CHARACTER) * 1_000_000_000).div_ceil(self.bits_per_second)
    }

    /// One start, eight data and one stop bit, ns, rounded up.
    pub fn character_ns(&self) -> u64 {
        self.characters_ns(1)
    }

    /// One bit, ps, rounded down.
    pub(super) fn bit_ps(&self) -> u64 {
        1_000_000_000_000 / self.bits_per_second
    }

    /// One bit, ns, rounded up.
    pub fn bit_ns(&self) -> u64 {
        1_000_000_000_u64.div_ceil(self.bits_per_second)
    }

    /// Silence that starts a new frame for the boards, ns.
    pub fn idle_gap_ns(&self) -> u64 {
        self.characters_ns(u64::from(IDLE_GAP_CHARACTERS))
    }

    /// The 555's write-enable pulse of the boards on this line.
    pub fn pulse(&self) -> Pulse {
        self.pulse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_protocols_wire_times() {
        for rate in [1_200, 115_200, 1_000_000, 7_812_500] {
            let baud = Baud::new(rate).unwrap();
            let line = Line::at_baud(baud).unwrap();
            for characters in 1..=20 {
                assert_eq!(line.characters_ns(u64::from(characters)), baud.characters_ns(characters));
            }
            assert_eq!(line.idle_gap_ns(), baud.idle_gap_ns());
            assert!(line.pulse().shortest_ns >= baud.packet_ns());
        }
    }
}
