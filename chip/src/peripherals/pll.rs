//! PLL_SYS and PLL_USB (2.18): locked as soon as they are powered, with the frequency of their
//! dividers.

use super::clocks::{Hertz, XOSC_HZ};
use super::{RegisterWrite, Written};

/// Register offsets.
const CS: u32 = 0x0;
const PWR: u32 = 0x4;
const FBDIV_INT: u32 = 0x8;
const PRIM: u32 = 0xc;

const CS_LOCK: u32 = 1 << 31;
const CS_WRITABLE: u32 = 0x13f;
const PWR_PD: u32 = 1 << 0;
const PWR_POSTDIVPD: u32 = 1 << 3;
const PWR_VCOPD: u32 = 1 << 5;

/// One PLL.
#[derive(Clone, Debug)]
pub(crate) struct Pll {
    control: u32,
    power_down: u32,
    feedback: u32,
    post_dividers: u32,
}

impl Default for Pll {
    fn default() -> Self {
        Pll { control: 1, power_down: 0x2d, feedback: 0, post_dividers: 0x0007_7000 }
    }
}

impl Pll {
    fn locked(&self) -> bool {
        self.power_down & (PWR_PD | PWR_VCOPD) == 0 && self.feedback != 0
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            CS => self.control | if self.locked() { CS_LOCK } else { 0 },
            PWR => self.power_down,
            FBDIV_INT => self.feedback,
            PRIM => self.post_dividers,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        match offset {
            CS => {
                self.control = write.onto(self.control) & CS_WRITABLE;
                // The bypass would pass the crystal through.
                if self.control & 1 << 8 != 0 {
                    return Written::ValueNotModelled;
                }
            }
            PWR => self.power_down = write.onto(self.power_down) & 0x2d,
            FBDIV_INT => self.feedback = write.onto(self.feedback) & 0xfff,
            PRIM => self.post_dividers = write.onto(self.post_dividers) & 0x0007_7000,
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// Crystal / REFDIV x FBDIV / (POSTDIV1 x POSTDIV2), 0 while powered down.
    pub fn output(&self) -> Hertz {
        let post = u64::from(self.post_dividers >> 16 & 7) * u64::from(self.post_dividers >> 12 & 7);
        if !self.locked() || self.power_down & PWR_POSTDIVPD != 0 || post == 0 {
            return (0, 1);
        }
        let reference = u64::from(self.control & 0x3f).max(1);
        (XOSC_HZ * u64::from(self.feedback), reference * post)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_dividers_give_125_mhz_once_powered() {
        let mut pll = Pll::default();
        assert_eq!(pll.output(), (0, 1));
        assert_eq!(pll.write(FBDIV_INT, RegisterWrite::plain(125)), Written::Done);
        assert_eq!(pll.read(CS), Some(1), "not locked while powered down");
        assert_eq!(pll.write(PWR, RegisterWrite::plain(PWR_POSTDIVPD)), Written::Done);
        assert_eq!(pll.read(CS), Some(CS_LOCK | 1));
        assert_eq!(pll.write(PRIM, RegisterWrite::plain(6 << 16 | 2 << 12)), Written::Done);
        assert_eq!(pll.write(PWR, RegisterWrite::plain(0)), Written::Done);
        assert_eq!(pll.output(), (1_500_000_000, 12));
    }
}
