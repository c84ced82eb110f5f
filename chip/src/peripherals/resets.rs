//! RESETS (2.14): which peripherals are held in reset.

use super::{RegisterWrite, Written};

/// Register offsets.
const RESET: u32 = 0x0;
const WDSEL: u32 = 0x4;
const RESET_DONE: u32 = 0x8;

/// Bits, the same in all three registers.
pub(crate) mod bit {
    pub const ADC: u32 = 1 << 0;
    pub const DMA: u32 = 1 << 2;
    pub const I2C0: u32 = 1 << 3;
    pub const I2C1: u32 = 1 << 4;
    pub const IO_BANK0: u32 = 1 << 5;
    pub const PADS_BANK0: u32 = 1 << 8;
    pub const PLL_SYS: u32 = 1 << 12;
    pub const PLL_USB: u32 = 1 << 13;
    pub const PWM: u32 = 1 << 14;
    pub const SPI0: u32 = 1 << 16;
    pub const SPI1: u32 = 1 << 17;
    pub const SYSCFG: u32 = 1 << 18;
    pub const SYSINFO: u32 = 1 << 19;
    pub const TBMAN: u32 = 1 << 20;
    pub const TIMER: u32 = 1 << 21;
    pub const UART0: u32 = 1 << 22;
    pub const UART1: u32 = 1 << 23;
}

/// All 25 subsystems.
pub(crate) const ALL: u32 = 0x01ff_ffff;

/// The RESETS block.
#[derive(Clone, Debug)]
pub(crate) struct Resets {
    /// Peripherals held in reset now.
    held: u32,
    /// Peripherals the watchdog resets.
    watchdog_select: u32,
}

impl Default for Resets {
    fn default() -> Self {
        Resets { held: ALL, watchdog_select: 0 }
    }
}

impl Resets {
    /// Whether any of these is held in reset.
    #[inline]
    pub fn holds(&self, peripherals: u32) -> bool {
        self.held & peripherals != 0
    }

    /// Peripherals the watchdog resets one by one, without the power-on state machine.
    pub fn watchdog_select(&self) -> u32 {
        self.watchdog_select
    }

    pub fn hold(&mut self, peripherals: u32) {
        self.held |= peripherals & ALL;
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            RESET => Some(self.held),
            WDSEL => Some(self.watchdog_select),
            // Leaving reset takes a few cycles of each peripheral's clock on the chip, none here.
            RESET_DONE => Some(!self.held & ALL),
            _ => None,
        }
    }

    /// Also returns the peripherals that have just been put into reset.
    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> (Written, u32) {
        match offset {
            RESET => {
                let before = self.held;
                self.held = write.onto(before) & ALL;
                (Written::Done, self.held & !before)
            }
            WDSEL => {
                self.watchdog_select = write.onto(self.watchdog_select) & ALL;
                (Written::Done, 0)
            }
            _ => (Written::NotModelled, 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripherals::Alias;

    #[test]
    fn releasing_one_peripheral_through_the_clear_alias_is_done_at_once() {
        let mut resets = Resets::default();
        let write = RegisterWrite { raw: bit::UART0, alias: Alias::Clear };
        assert_eq!(resets.write(RESET, write), (Written::Done, 0));
        assert!(!resets.holds(bit::UART0));
        assert!(resets.holds(bit::UART1));
        assert_eq!(resets.read(RESET_DONE), Some(bit::UART0));
    }

    #[test]
    fn putting_a_peripheral_into_reset_tells_which() {
        let mut resets = Resets::default();
        assert_eq!(resets.write(RESET, RegisterWrite::plain(0)), (Written::Done, 0));
        assert_eq!(resets.write(RESET, RegisterWrite::plain(bit::ADC)), (Written::Done, bit::ADC));
        assert_eq!(resets.write(RESET, RegisterWrite::plain(bit::ADC)), (Written::Done, 0));
    }
}
