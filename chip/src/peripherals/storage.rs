//! Blocks that only have to be there: they hold what is written and stay idle for ever.
//!
//! I2C0/1 (4.3) and SPI0/1 (4.4) without a bus behind them, SYSCFG (2.21), SYSINFO (2.20), TBMAN (2.22) and
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

/// DW_apb_i2c (4.3.17), idle: FIFOs empty, no activity.
pub(crate) const I2C: &[StoredRegister] = &[
    register(0x00, 0x65, 0x3ff),       // IC_CON
    register(0x04, 0x55, 0xfff),       // IC_TAR
    register(0x08, 0x55, 0x3ff),       // IC_SAR
    register(0x14, 0x28, 0xffff),      // IC_SS_SCL_HCNT
    register(0x18, 0x2f, 0xffff),      // IC_SS_SCL_LCNT
    register(0x1c, 0x06, 0xffff),      // IC_FS_SCL_HCNT
    register(0x20, 0x0d, 0xffff),      // IC_FS_SCL_LCNT
    register(0x2c, 0, 0),              // IC_INTR_STAT
    register(0x30, 0x8ff, 0x1fff),     // IC_INTR_MASK
    register(0x34, 0, 0),              // IC_RAW_INTR_STAT
    register(0x38, 0, 0xff),           // IC_RX_TL
    register(0x3c, 0, 0xff),           // IC_TX_TL
    register(0x40, 0, 0),              // IC_CLR_INTR
    register(0x54, 0, 0),              // IC_CLR_TX_ABRT
    register(0x6c, 0, 7),              // IC_ENABLE
    register(0x70, 0x06, 0),           // IC_STATUS: both FIFOs not full, TX empty
    register(0x74, 0, 0),              // IC_TXFLR
    register(0x78, 0, 0),              // IC_RXFLR
    register(0x7c, 0x01, 0x00ff_ffff), // IC_SDA_HOLD
    register(0x80, 0, 0),              // IC_TX_ABRT_SOURCE
    register(0x88, 0, 3),              // IC_DMA_CR
    register(0x8c, 0, 0xf),            // IC_DMA_TDLR
    register(0x90, 0, 0xf),            // IC_DMA_RDLR
    register(0xa0, 0x07, 0xff),        // IC_FS_SPKLEN
];

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
        let mut i2c = Storage::new(I2C);
        assert_eq!(i2c.write(0x6c, RegisterWrite::plain(0xffff_ffff)), Written::Done);
        assert_eq!(i2c.read(0x6c), Some(7));
        assert_eq!(i2c.write(0x70, RegisterWrite::plain(0)), Written::Done);
        assert_eq!(i2c.read(0x70), Some(6), "IC_STATUS is read-only");
        assert_eq!(
            i2c.write(0x10, RegisterWrite::plain(1)),
            Written::NotModelled,
            "IC_DATA_CMD would start a transfer"
        );
        i2c.reset();
        assert_eq!(i2c.read(0x6c), Some(0));
    }
}
