//! CLOCKS (2.15): the clock generators the firmware uses, and the frequencies that come of their
//! settings.

use super::{RegisterWrite, Written};

/// Register offsets. Every generator has CTRL, DIV, SELECTED, in this order.
const CLK_GPOUT0_CTRL: u32 = 0x00;
const CLK_REF_CTRL: u32 = 0x30;
const CLK_REF_DIV: u32 = 0x34;
const CLK_REF_SELECTED: u32 = 0x38;
const CLK_SYS_CTRL: u32 = 0x3c;
const CLK_SYS_DIV: u32 = 0x40;
const CLK_SYS_SELECTED: u32 = 0x44;
const CLK_PERI_CTRL: u32 = 0x48;
const CLK_ADC_CTRL: u32 = 0x60;
const CLK_ADC_DIV: u32 = 0x64;
const CLK_RTC_SELECTED: u32 = 0x74;
const CLK_SYS_RESUS_CTRL: u32 = 0x78;
const CLK_SYS_RESUS_STATUS: u32 = 0x7c;
const WAKE_EN0: u32 = 0xa0;
const WAKE_EN1: u32 = 0xa4;
const SLEEP_EN0: u32 = 0xa8;
const SLEEP_EN1: u32 = 0xac;
const ENABLED0: u32 = 0xb0;
const ENABLED1: u32 = 0xb4;
const INTR: u32 = 0xb8;
const INTS: u32 = 0xc4;

const ENABLE: u32 = 1 << 11;
/// A divider of one, in 24.8 and in 24.0 with eight unused bits below.
const DIVIDE_BY_1: u32 = 0x100;

/// What an integer divider field of 0 divides by.
const DIVIDER_OF_ZERO: u64 = 1 << 16;

/// A frequency as a fraction, hertz.
pub(crate) type Hertz = (u64, u64);

/// Crystal on every board known, Hz.
pub(crate) const XOSC_HZ: u64 = 12_000_000;
/// Frequencies of the sources, from the other blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sources {
    pub rosc: Hertz,
    pub pll_sys: Hertz,
    pub pll_usb: Hertz,
}

/// Registers 0x00 to 0xb4 by word.
#[derive(Clone, Debug)]
pub(crate) struct Clocks {
    words: [u32; 0xb8 / 4],
}

impl Default for Clocks {
    fn default() -> Self {
        let mut words = [0; 0xb8 / 4];
        for generator in 0..10 {
            words[3 * generator + 1] = DIVIDE_BY_1;
        }
        for enable in [WAKE_EN0, SLEEP_EN0, ENABLED0] {
            words[(enable / 4) as usize] = 0xffff_ffff;
            words[(enable / 4) as usize + 1] = 0x7fff;
        }
        Clocks { words }
    }
}

impl Clocks {
    fn word(&self, offset: u32) -> u32 {
        self.words[(offset / 4) as usize]
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            // One-hot: the glitchless multiplexers switch at once.
            CLK_REF_SELECTED => 1 << (self.word(CLK_REF_CTRL) & 3),
            CLK_SYS_SELECTED => 1 << (self.word(CLK_SYS_CTRL) & 1),
            // The others have no glitchless multiplexer and read 1.
            _ if offset <= CLK_RTC_SELECTED && offset % 12 == 8 => 1,
            CLK_SYS_RESUS_STATUS => 0,
            ENABLED0 => self.word(WAKE_EN0),
            ENABLED1 => self.word(WAKE_EN1),
            CLK_GPOUT0_CTRL..=CLK_RTC_SELECTED | CLK_SYS_RESUS_CTRL | WAKE_EN0..=SLEEP_EN1 => {
                self.word(offset)
            }
            INTR..=INTS => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        let word = (offset / 4) as usize;
        match offset {
            _ if offset <= CLK_RTC_SELECTED && offset % 12 == 8 => Written::Done,
            CLK_GPOUT0_CTRL..=CLK_RTC_SELECTED | WAKE_EN0..=SLEEP_EN1 => {
                self.words[word] = write.onto(self.words[word]);
                Written::Done
            }
            CLK_SYS_RESUS_CTRL => {
                self.words[word] = write.onto(self.words[word]);
                // Resuscitation off is what is modelled.
                if self.words[word] & 1 << 8 == 0 { Written::Done } else { Written::ValueNotModelled }
            }
            _ => Written::NotModelled,
        }
    }

    /// clk_ref, which the watchdog's tick divides.
    pub fn clk_ref(&self, sources: Sources) -> Hertz {
        let control = self.word(CLK_REF_CTRL);
        let source = match control & 3 {
            0 => sources.rosc,
            2 => (XOSC_HZ, 1),
            _ if control >> 5 & 3 == 0 => sources.pll_usb,
            _ => (0, 1),
        };
        divide_integer(source, self.word(CLK_REF_DIV))
    }

    /// clk_sys: processor, bus, PWM, DMA.
    pub fn clk_sys(&self, sources: Sources) -> Hertz {
        let control = self.word(CLK_SYS_CTRL);
        let source = match (control & 1, control >> 5 & 7) {
            (0, _) => self.clk_ref(sources),
            (_, 0) => sources.pll_sys,
            (_, 1) => sources.pll_usb,
            (_, 2) => sources.rosc,
            (_, 3) => (XOSC_HZ, 1),
            _ => (0, 1),
        };
        // 24.8 fixed point.
        match self.word(CLK_SYS_DIV) {
            0 => divide(source, DIVIDER_OF_ZERO, 1),
            divider => divide(source, u64::from(divider), 256),
        }
    }

    /// clk_peri: UART and SPI. It has no divider.
    pub fn clk_peri(&self, sources: Sources) -> Hertz {
        let control = self.word(CLK_PERI_CTRL);
        match (control & ENABLE, control >> 5 & 7) {
            (0, _) => (0, 1),
            (_, 0) => self.clk_sys(sources),
            (_, 1) => sources.pll_sys,
            (_, 2) => sources.pll_usb,
            (_, 3) => sources.rosc,
            (_, 4) => (XOSC_HZ, 1),
            _ => (0, 1),
        }
    }

    /// clk_adc: nominally 48 MHz.
    pub fn clk_adc(&self, sources: Sources) -> Hertz {
        let control = self.word(CLK_ADC_CTRL);
        let source = match (control & ENABLE, control >> 5 & 7) {
            (0, _) => (0, 1),
            (_, 0) => sources.pll_usb,
            (_, 1) => sources.pll_sys,
            (_, 2) => sources.rosc,
            (_, 3) => (XOSC_HZ, 1),
            _ => (0, 1),
        };
        divide_integer(source, self.word(CLK_ADC_DIV))
    }
}

fn divide(frequency: Hertz, numerator: u64, denominator: u64) -> Hertz {
    (frequency.0 * denominator, frequency.1 * numerator)
}

/// The two-bit integer dividers of clk_ref and clk_adc in bits 9 and 8.
fn divide_integer(frequency: Hertz, register: u32) -> Hertz {
    match register >> 8 & 3 {
        0 => divide(frequency, DIVIDER_OF_ZERO, 1),
        divider => divide(frequency, u64::from(divider), 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCES: Sources =
        Sources { rosc: (6_500_000, 1), pll_sys: (125_000_000, 1), pll_usb: (48_000_000, 1) };

    fn hertz((numerator, denominator): Hertz) -> f64 {
        numerator as f64 / denominator as f64
    }

    #[test]
    fn after_reset_everything_runs_from_the_ring_oscillator() {
        let clocks = Clocks::default();
        assert_eq!(hertz(clocks.clk_ref(SOURCES)), 6.5e6);
        assert_eq!(hertz(clocks.clk_sys(SOURCES)), 6.5e6);
        assert_eq!(hertz(clocks.clk_peri(SOURCES)), 0.0, "not enabled");
        assert_eq!(clocks.read(CLK_SYS_SELECTED), Some(1));
    }

    #[test]
    fn the_usual_settings_give_the_usual_clocks() {
        let mut clocks = Clocks::default();
        assert_eq!(clocks.write(CLK_REF_CTRL, RegisterWrite::plain(2)), Written::Done);
        assert_eq!(clocks.write(CLK_SYS_CTRL, RegisterWrite::plain(1)), Written::Done);
        assert_eq!(clocks.write(CLK_PERI_CTRL, RegisterWrite::plain(ENABLE)), Written::Done);
        assert_eq!(clocks.write(CLK_ADC_CTRL, RegisterWrite::plain(ENABLE)), Written::Done);
        assert_eq!(hertz(clocks.clk_ref(SOURCES)), 12e6);
        assert_eq!(hertz(clocks.clk_sys(SOURCES)), 125e6);
        assert_eq!(hertz(clocks.clk_peri(SOURCES)), 125e6);
        assert_eq!(hertz(clocks.clk_adc(SOURCES)), 48e6);
        assert_eq!(clocks.read(CLK_REF_SELECTED), Some(4));
        assert_eq!(clocks.read(CLK_SYS_SELECTED), Some(2));
    }

    #[test]
    fn clk_sys_has_a_fractional_divider() {
        let mut clocks = Clocks::default();
        assert_eq!(clocks.write(CLK_SYS_CTRL, RegisterWrite::plain(1)), Written::Done);
        assert_eq!(clocks.write(CLK_SYS_DIV, RegisterWrite::plain(0x280)), Written::Done);
        assert_eq!(hertz(clocks.clk_sys(SOURCES)), 50e6);
    }
}
