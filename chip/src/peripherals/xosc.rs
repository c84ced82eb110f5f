//! XOSC, the crystal oscillator (2.16): it becomes stable after its start-up delay.

use super::clocks::XOSC_HZ;
use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

/// Register offsets.
const CTRL: u32 = 0x00;
const STATUS: u32 = 0x04;
const DORMANT: u32 = 0x08;
const STARTUP: u32 = 0x0c;
const COUNT: u32 = 0x1c;

const ENABLE_FIELD: u32 = 0xfff << 12;
const ENABLE: u32 = 0xfab << 12;
const STATUS_STABLE: u32 = 1 << 31;
const STATUS_ENABLED: u32 = 1 << 12;

/// The XOSC block.
#[derive(Clone, Debug)]
pub(crate) struct Xosc {
    control: u32,
    /// In units of 256 crystal cycles.
    startup: u32,
    stable_at: Ticks,
}

impl Default for Xosc {
    fn default() -> Self {
        Xosc { control: 0, startup: 0x00c4, stable_at: Ticks::NEVER }
    }
}

impl Xosc {
    pub fn read(&self, offset: u32, now: Ticks) -> Option<u32> {
        match offset {
            CTRL => Some(self.control),
            STATUS => {
                let enabled = if self.control & ENABLE_FIELD == ENABLE { STATUS_ENABLED } else { 0 };
                let stable = if now >= self.stable_at { STATUS_STABLE } else { 0 };
                Some(enabled | stable)
            }
            STARTUP => Some(self.startup),
            COUNT => Some(0),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        match offset {
            CTRL => {
                let was_enabled = self.control & ENABLE_FIELD == ENABLE;
                self.control = write.onto(self.control);
                let enabled = self.control & ENABLE_FIELD == ENABLE;
                if !enabled {
                    self.stable_at = Ticks::NEVER;
                } else if !was_enabled {
                    let delay = Rate::hertz(XOSC_HZ, 256).ticks_for(u64::from(self.startup & 0x3fff));
                    self.stable_at = now + delay;
                }
            }
            STARTUP => self.startup = write.onto(self.startup),
            // The oscillator would stop until a pin wakes it.
            DORMANT => return Written::ValueNotModelled,
            COUNT => return Written::ValueNotModelled,
            _ => return Written::NotModelled,
        }
        Written::Done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_stable_after_the_startup_delay() {
        let mut xosc = Xosc::default();
        let start = Ticks::from_micros(10);
        assert_eq!(xosc.write(STARTUP, RegisterWrite::plain(47), start), Written::Done);
        assert_eq!(xosc.write(CTRL, RegisterWrite::plain(ENABLE | 0xaa0), start), Written::Done);
        // 47 x 256 cycles of 12 MHz = 1002.667 us = 125333.3 ticks.
        let before = start + Ticks::new(125_333);
        assert_eq!(xosc.read(STATUS, before), Some(STATUS_ENABLED));
        assert_eq!(xosc.read(STATUS, before + Ticks::new(1)), Some(STATUS_ENABLED | STATUS_STABLE));
    }
}
