//! Blocks that only have to be there: they hold what is written and stay idle for ever.
//!
//! SPI0/1 (4.4) without a bus behind them, SYSCFG (2.21), SYSINFO (2.20), TBMAN (2.22) and
//! PADS_QSPI (2.19.6).

use super::{RegisterWrite, Written};

/// A register of such a block: offset, value after reset, bits that can be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StoredRegister {
    offset: u32,
    reset: u32,
    writable: u32,
}

const fn register(offset: u32, reset: u32, writable: u32) -> StoredRegister {
    StoredRegister { offset, reset, writable }
}

/// PL022 (4.4.4), idle: transmit FIFO empty and not full.
pub(crate) const SPI: &[StoredRegister] = &[
    register(0x00, 0, 0xffff), // SSPCR0
    register(0x04, 0, 0xf),    // SSPCR1
    register(0x0c, 0x03, 0),   // SSPSR
    register(0x10, 0, 0xff),   // SSPCPSR
    register(0x14, 0, 0xf),    // SSPIMSC
    register(0x18, 0x08, 0),   // SSPRIS
    register(0x1c, 0, 0),      // SSPMIS
    register(0x20, 0, 0),      // SSPICR
    register(0x24, 0, 3),      // SSPDMACR
];

/// SYSINFO: an RP2040 B2.
pub(crate) const SYSINFO: &[StoredRegister] = &[
    register(0x00, 0x2000_2927, 0), // CHIP_ID
    register(0x04, 0x2, 0),         // PLATFORM: ASIC
];

/// SYSCFG without the NMI masks, which nobody here honours.
pub(crate) const SYSCFG: &[StoredRegister] = &[
    register(0x0c, 0, 0x3fff_ffff), // PROC_IN_SYNC_BYPASS
    register(0x10, 0, 0x3f),        // PROC_IN_SYNC_BYPASS_HI
];

/// PADS_QSPI: the pads of the flash chip.
pub(crate) const PADS_QSPI: &[StoredRegister] = &[
    register(0x00, 0, 1),       // VOLTAGE_SELECT
    register(0x04, 0x56, 0xff), // SCLK
    register(0x08, 0x52, 0xff), // SD0
    register(0x0c, 0x52, 0xff), // SD1
    register(0x10, 0x52, 0xff), // SD2
    register(0x14, 0x52, 0xff), // SD3
    register(0x18, 0x5a, 0xff), // SS
];

/// TBMAN: an ASIC.
pub(crate) const TBMAN: &[StoredRegister] = &[register(0x00, 1, 0)];

/// Values of a block's registers, in the order of its table.
#[derive(Clone, Debug)]
pub(crate) struct Storage {
    registers: &'static [StoredRegister],
    values: Vec<u32>,
}

impl Storage {
    pub fn new(registers: &'static [StoredRegister]) -> Storage {
        Storage { registers, values: registers.iter().map(|r| r.reset).collect() }
    }

    pub fn reset(&mut self) {
        *self = Storage::new(self.registers);
    }

    fn position(&self, offset: u32) -> Option<usize> {
        self.registers.iter().position(|r| r.offset == offset)
    }

    pub fn read(&self, offset: u32) -> Option<u32> {
        self.position(offset).map(|i| self.values[i])
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        let Some(i) = self.position(offset) else { return Written::NotModelled };
        self.values[i] = write.onto_bits(self.values[i], self.registers[i].writable);
        Written::Done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_writable_bits_of_listed_registers_change() {
        let mut spi = Storage::new(SPI);
        assert_eq!(spi.write(0x04, RegisterWrite::plain(0xffff_ffff)), Written::Done);
        assert_eq!(spi.read(0x04), Some(0xf));
        assert_eq!(spi.write(0x0c, RegisterWrite::plain(0)), Written::Done);
        assert_eq!(spi.read(0x0c), Some(3), "SSPSR is read-only");
        assert_eq!(
            spi.write(0x08, RegisterWrite::plain(1)),
            Written::NotModelled,
            "SSPDR would start a transfer"
        );
        spi.reset();
        assert_eq!(spi.read(0x04), Some(0));
    }
}
