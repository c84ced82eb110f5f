//! ROSC, the ring oscillator (2.17): storage, always stable, and a pseudo-random bit.

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

const STATUS_STABLE: u32 = 1 << 31;
const STATUS_ENABLED: u32 = 1 << 12;

/// The ROSC block. Its frequency stays nominal whatever FREQA, FREQB and DIV say.
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
    fn it_is_stable_and_its_random_bits_are_balanced() {
        let mut rosc = Rosc::default();
        assert_eq!(rosc.read(STATUS), Some(STATUS_STABLE | STATUS_ENABLED));
        let ones: u32 = (0..1000).filter_map(|_| rosc.read(RANDOMBIT)).sum();
        assert!((450..550).contains(&ones), "{ones}");
    }
}
