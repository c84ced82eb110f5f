//! SIO (2.3.1): GPIO outputs, spinlocks, the hardware divider, CPUID. Core 1 is never there.

mod divider;

use divider::Divider;

/// Register offsets (2.3.1.7).
const CPUID: u32 = 0x000;
/// The pins' levels, which the bus knows.
pub(crate) const GPIO_IN: u32 = 0x004;
const GPIO_HI_IN: u32 = 0x008;
const GPIO_OUT: u32 = 0x010;
const GPIO_OUT_SET: u32 = 0x014;
const GPIO_OUT_CLR: u32 = 0x018;
const GPIO_OUT_XOR: u32 = 0x01c;
const GPIO_OE: u32 = 0x020;
const GPIO_OE_SET: u32 = 0x024;
const GPIO_OE_CLR: u32 = 0x028;
const GPIO_OE_XOR: u32 = 0x02c;
const FIFO_ST: u32 = 0x050;
const FIFO_RD: u32 = 0x058;
const SPINLOCK_ST: u32 = 0x05c;
const DIV_UDIVIDEND: u32 = 0x060;
const DIV_CSR: u32 = 0x078;
const SPINLOCK0: u32 = 0x100;
const SPINLOCK31: u32 = 0x17c;

const PIN_MASK: u32 = 0x3fff_ffff;
/// FIFO_ST: the mailbox to core 1 is ready for writing; nothing ever comes back.
const FIFO_ST_RDY: u32 = 1 << 1;
/// The QSPI pins as flash leaves them: SS, SD0 to SD3 high, SCLK low.
const QSPI_IDLE: u32 = 0x3e;

/// The SIO block as core 0 sees it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sio {
    output: u32,
    output_enable: u32,
    spinlocks: u32,
    divider: Divider,
}

impl Sio {
    /// GPIO_OUT.
    pub fn output(&self) -> u32 {
        self.output
    }

    /// GPIO_OE.
    pub fn output_enable(&self) -> u32 {
        self.output_enable
    }

    /// Every register but GPIO_IN.
    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            CPUID => 0,
            GPIO_HI_IN => QSPI_IDLE,
            GPIO_OUT..=GPIO_OUT_XOR => self.output,
            GPIO_OE..=GPIO_OE_XOR => self.output_enable,
            FIFO_ST => FIFO_ST_RDY,
            FIFO_RD => 0,
            SPINLOCK_ST => self.spinlocks,
            DIV_UDIVIDEND..=DIV_CSR => self.divider.read(offset),
            SPINLOCK0..=SPINLOCK31 => self.claim((offset - SPINLOCK0) / 4),
            _ => return None,
        })
    }

    /// Reading a free spinlock claims it and gives its bit; a taken one gives 0 (2.3.1.3).
    fn claim(&mut self, number: u32) -> u32 {
        let bit = 1 << number;
        if self.spinlocks & bit != 0 {
            return 0;
        }
        self.spinlocks |= bit;
        bit
    }

    /// Whether there is such a register.
    pub fn write(&mut self, offset: u32, value: u32) -> bool {
        match offset {
            GPIO_OUT => self.output = value,
            GPIO_OUT_SET => self.output |= value,
            GPIO_OUT_CLR => self.output &= !value,
            GPIO_OUT_XOR => self.output ^= value,
            GPIO_OE => self.output_enable = value,
            GPIO_OE_SET => self.output_enable |= value,
            GPIO_OE_CLR => self.output_enable &= !value,
            GPIO_OE_XOR => self.output_enable ^= value,
            // Clears the sticky error flags, of which there are none.
            FIFO_ST => {}
            DIV_UDIVIDEND..=DIV_CSR => self.divider.write(offset, value),
            SPINLOCK0..=SPINLOCK31 => self.spinlocks &= !(1 << ((offset - SPINLOCK0) / 4)),
            _ => return false,
        }
        self.output &= PIN_MASK;
        self.output_enable &= PIN_MASK;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spinlock_is_given_once() {
        let mut sio = Sio::default();
        assert_eq!(sio.read(SPINLOCK31), Some(1 << 31));
        assert_eq!(sio.read(SPINLOCK31), Some(0));
        assert_eq!(sio.read(SPINLOCK_ST), Some(1 << 31));
        assert!(sio.write(SPINLOCK31, 0));
        assert_eq!(sio.read(SPINLOCK31), Some(1 << 31));
    }

    #[test]
    fn set_clear_and_toggle_touch_their_bits_only() {
        let mut sio = Sio::default();
        assert!(sio.write(GPIO_OUT, 0b1100));
        assert!(sio.write(GPIO_OUT_SET, 0b0001));
        assert!(sio.write(GPIO_OUT_CLR, 0b0100));
        assert!(sio.write(GPIO_OUT_XOR, 0b1010));
        assert_eq!(sio.output(), 0b0011);
        assert!(sio.write(GPIO_OE_SET, 0xffff_ffff));
        assert_eq!(sio.output_enable(), PIN_MASK, "30 pins");
    }

    #[test]
    fn unknown_registers_are_refused() {
        let mut sio = Sio::default();
        let interpolator_0_accumulator = 0x080;
        assert_eq!(sio.read(interpolator_0_accumulator), None);
        assert!(!sio.write(interpolator_0_accumulator, 1));
    }
}
