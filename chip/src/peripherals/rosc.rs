//! ROSC, the ring oscillator (2.17): its divider, otherwise storage, always stable, and a
//! pseudo-random bit.

use super::clocks::Hertz;
use super::{RegisterWrite, Written};

/// Register offsets.
const CTRL: u32 = 0x00;
const FREQA: u32 = 0x04;
const FREQB: u32 = 0x08;
const DORMANT: u32 = 0x0c;
const DIV: u32 = 0x10;
const PHASE: u32 = 0x14;
const STATUS: u32 = 0x18;
const RANDOMBIT: u32 = 0x1c;
const COUNT: u32 = 0x20;

/// DIV: 0xaa0 + the divisor, where 0 stands for 32; what is none divides by 31.
const DIVIDER_PASS: u32 = 0xaa0;
const DIVIDERS: u32 = 32;
/// The ring itself: nominally 6.5 MHz after reset, divided by 16 (2.17.1). The real one gives 1.8
/// to 12 MHz then.
const RING_HZ: u64 = 16 * 6_500_000;

const STATUS_STABLE: u32 = 1 << 31;
const STATUS_ENABLED: u32 = 1 << 12;

/// The ROSC block. The ring's frequency stays nominal whatever FREQA and FREQB say.
#[derive(Clone, Debug)]
pub(crate) struct Rosc {
    control: u32,
    freq_a: u32,
    freq_b: u32,
    divider: u32,
    phase: u32,
    random: u32,
}

impl Default for Rosc {
    fn default() -> Self {
        Rosc { control: 0xaa0, freq_a: 0, freq_b: 0, divider: 0xab0, phase: 0x8, random: 0x2545_f491 }
    }
}

impl Rosc {
    /// What it gives to the clocks. A new divisor acts at once, without a glitch (2.17.5).
    pub fn output(&self) -> Hertz {
        let divisor = match self.divider.checked_sub(DIVIDER_PASS) {
            Some(0) => DIVIDERS,
            Some(divisor) if divisor < DIVIDERS => divisor,
            _ => DIVIDERS - 1,
        };
        (RING_HZ, divisor.into())
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            CTRL => self.control,
            FREQA => self.freq_a,
            FREQB => self.freq_b,
            DIV => self.divider,
            PHASE => self.phase,
            STATUS => STATUS_STABLE | STATUS_ENABLED,
            RANDOMBIT => self.random_bit(),
            COUNT => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        match offset {
            CTRL => self.control = write.onto(self.control),
            FREQA => self.freq_a = write.onto(self.freq_a),
            FREQB => self.freq_b = write.onto(self.freq_b),
            DIV => self.divider = write.onto(self.divider),
            PHASE => self.phase = write.onto(self.phase),
            DORMANT | COUNT => return Written::ValueNotModelled,
            // Write-one-to-clear BADWRITE.
            STATUS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// Xorshift instead of jitter: the same in every run.
    fn random_bit(&mut self) -> u32 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 17;
        self.random ^= self.random << 5;
        self.random >> 16 & 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_divider_sets_its_frequency() {
        let mut rosc = Rosc::default();
        assert_eq!(rosc.output(), (RING_HZ, 16));
        for (value, divisor) in [(0xaa8, 8), (0xaa1, 1), (0xaa0, 32), (0xabf, 31), (0xac0, 31), (8, 31)] {
            assert_eq!(rosc.write(DIV, RegisterWrite::plain(value)), Written::Done);
            assert_eq!(rosc.output(), (RING_HZ, divisor), "{value:x}");
        }
    }

    #[test]
    fn it_is_stable_and_its_random_bits_are_balanced() {
        let mut rosc = Rosc::default();
        assert_eq!(rosc.read(STATUS), Some(STATUS_STABLE | STATUS_ENABLED));
        let ones: u32 = (0..1000).filter_map(|_| rosc.read(RANDOMBIT)).sum();
        assert!((450..550).contains(&ones), "{ones}");
    }
}
