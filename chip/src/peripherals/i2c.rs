//! I2C0 and I2C1 (4.3): DW_apb_i2c as the only controller ("master") of a bus, with 7-bit
//! addresses.

mod registers;
mod transfer;
mod wires;

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

use registers::*;
use transfer::Phase;
pub(crate) use wires::I2cWires;

const FIFO_DEPTH: usize = 16;

/// An entry of the transmit FIFO: a byte to write, or one to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Command {
    byte: u8,
    read: bool,
    stop: bool,
    restart: bool,
}

/// One I2C block with the bus at its pins.
#[derive(Clone, Debug)]
pub(crate) struct I2c {
    control: u32,
    target: u32,
    own_address: u32,
    /// High and low counts, standard and fast mode.
    standard: [u32; 2],
    fast: [u32; 2],
    spike: u32,
    sda_hold: u32,
    sda_setup: u32,
    dma_levels: [u32; 2],
    mask: u32,
    /// Interrupts that stay until they are cleared.
    latched: u32,
    rx_level: u32,
    tx_level: u32,
    enable: u32,
    abort_source: u32,
    commands: VecDeque<Command>,
    received: VecDeque<u8>,
    clock: Rate,
    /// Both lines are high at pins that are switched to this block.
    lines_free: bool,
    phase: Phase,
    pub wires: I2cWires,
}

impl Default for I2c {
    fn default() -> Self {
        I2c {
            control: 0x65,
            target: 0x55,
            own_address: 0x55,
            standard: [0x28, 0x2f],
            fast: [0x06, 0x0d],
            spike: 7,
            sda_hold: 1,
            sda_setup: 0x64,
            dma_levels: [0; 2],
            mask: 0x8ff,
            latched: 0,
            rx_level: 0,
            tx_level: 0,
            enable: 0,
            abort_source: 0,
            commands: VecDeque::new(),
            received: VecDeque::new(),
            clock: Rate::STOPPED,
            lines_free: false,
            phase: Phase::Idle,
            wires: I2cWires::default(),
        }
    }
}

impl I2c {
    /// The block after a reset at `now`. A part that was sending goes on holding the bit that it
    /// was at.
    pub fn reset(&mut self, now: Ticks) {
        self.cut(now);
        let wires = std::mem::take(&mut self.wires);
        *self = I2c { clock: self.clock, lines_free: self.lines_free, wires, ..I2c::default() };
    }

    /// clk_sys is now `numerator / denominator` hertz.
    pub fn set_clock(&mut self, (numerator, denominator): (u64, u64)) {
        self.clock = Rate::hertz(numerator, denominator);
    }

    /// Whether both lines are high at pins that are switched to this block.
    pub fn set_lines_free(&mut self, free: bool, now: Ticks) {
        self.lines_free = free;
        self.go_on(now);
    }

    /// Duration of a bit (4.3.14.2): SCL low for LCNT + 1 cycles, high for HCNT + SPKLEN + 7.
    fn bits(&self, bits: u64) -> Ticks {
        let [high, low] = if self.control >> 1 & 3 == 1 { self.standard } else { self.fast };
        self.clock.ticks_for(bits * u64::from(high + self.spike + 7 + low + 1))
    }

    fn is_enabled(&self) -> bool {
        self.enable & ENABLE != 0
    }

    fn raw(&self) -> u32 {
        let bit = |set: bool, bit: u32| if set { bit } else { 0 };
        let level = self.commands.len() <= self.tx_level as usize;
        let shifts = self.control & TX_EMPTY_CTRL != 0 && self.phase.shifts();
        self.latched
            | bit(self.received.len() > self.rx_level as usize, RX_FULL)
            | bit(self.is_enabled() && level && !shifts, TX_EMPTY)
    }

    fn status(&self) -> u32 {
        let bit = |set: bool, n: u32| u32::from(set) << n;
        let active = self.phase != Phase::Idle;
        bit(active, 0)
            | bit(self.commands.len() < FIFO_DEPTH, 1)
            | bit(self.commands.is_empty(), 2)
            | bit(!self.received.is_empty(), 3)
            | bit(self.received.len() >= FIFO_DEPTH, 4)
            | bit(active, 5)
    }

    /// Reading one of the registers that clear an interrupt.
    fn clear(&mut self, interrupts: u32) -> u32 {
        self.latched &= !interrupts;
        if interrupts & TX_ABRT != 0 {
            self.abort_source = 0;
        }
        0
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            IC_CON => self.control,
            IC_TAR => self.target,
            IC_SAR => self.own_address,
            IC_DATA_CMD => self.received.pop_front().map_or_else(
                || {
                    self.latched |= RX_UNDER;
                    0
                },
                u32::from,
            ),
            IC_SS_SCL_HCNT => self.standard[0],
            IC_SS_SCL_LCNT => self.standard[1],
            IC_FS_SCL_HCNT => self.fast[0],
            IC_FS_SCL_LCNT => self.fast[1],
            IC_INTR_STAT => self.raw() & self.mask,
            IC_INTR_MASK => self.mask,
            IC_RAW_INTR_STAT => self.raw(),
            IC_RX_TL => self.rx_level,
            IC_TX_TL => self.tx_level,
            IC_CLR_INTR => self.clear(!0),
            IC_CLR_RX_UNDER => self.clear(RX_UNDER),
            IC_CLR_RX_OVER => self.clear(RX_OVER),
            IC_CLR_TX_OVER => self.clear(TX_OVER),
            IC_CLR_RD_REQ => self.clear(RD_REQ),
            IC_CLR_TX_ABRT => self.clear(TX_ABRT),
            IC_CLR_RX_DONE => self.clear(RX_DONE),
            IC_CLR_ACTIVITY => self.clear(ACTIVITY),
            IC_CLR_STOP_DET => self.clear(STOP_DET),
            IC_CLR_START_DET => self.clear(START_DET),
            IC_CLR_GEN_CALL => self.clear(GEN_CALL),
            IC_CLR_RESTART_DET => self.clear(RESTART_DET),
            IC_ENABLE => self.enable,
            IC_STATUS => self.status(),
            IC_TXFLR => self.commands.len() as u32,
            IC_RXFLR => self.received.len() as u32,
            IC_SDA_HOLD => self.sda_hold,
            IC_TX_ABRT_SOURCE => self.abort_source,
            IC_DMA_CR => 0,
            IC_DMA_TDLR => self.dma_levels[0],
            IC_DMA_RDLR => self.dma_levels[1],
            IC_SDA_SETUP => self.sda_setup,
            IC_ENABLE_STATUS => u32::from(self.is_enabled() || self.phase != Phase::Idle),
            IC_FS_SPKLEN => self.spike,
            IC_COMP_PARAM_1 => 0,
            IC_COMP_VERSION => 0x3230_312a,
            IC_COMP_TYPE => 0x4457_0140,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        // The bus has read, modified and written: there are no aliases here.
        let value = write.raw;
        match offset {
            // These can only be written while the block is off.
            IC_CON | IC_TAR | IC_SAR | IC_SS_SCL_HCNT..=IC_FS_SCL_LCNT | IC_FS_SPKLEN
                if self.is_enabled() => {}
            IC_CON => {
                self.control = value & 0x3ff;
                let modes = MASTER_MODE | SLAVE_DISABLE | MASTER_10_BIT;
                if self.control & modes != MASTER_MODE | SLAVE_DISABLE {
                    return Written::ValueNotModelled;
                }
            }
            IC_TAR => {
                self.target = value & 0xfff;
                // General call, START byte.
                if self.target >> 10 != 0 {
                    return Written::ValueNotModelled;
                }
            }
            IC_SAR => self.own_address = value & 0x3ff,
            IC_DATA_CMD => self.push(value, now),
            IC_SS_SCL_HCNT => self.standard[0] = value & 0xffff,
            IC_SS_SCL_LCNT => self.standard[1] = value & 0xffff,
            IC_FS_SCL_HCNT => self.fast[0] = value & 0xffff,
            IC_FS_SCL_LCNT => self.fast[1] = value & 0xffff,
            IC_FS_SPKLEN => self.spike = value & 0xff,
            IC_INTR_MASK => self.mask = value & 0x1fff,
            IC_RX_TL => self.rx_level = (value & 0xff).min(FIFO_DEPTH as u32 - 1),
            IC_TX_TL => self.tx_level = (value & 0xff).min(FIFO_DEPTH as u32 - 1),
            IC_ENABLE => self.write_enable(value & 7, now),
            IC_SDA_HOLD => self.sda_hold = value & 0x00ff_ffff,
            IC_SDA_SETUP => self.sda_setup = value & 0xff,
            IC_DMA_TDLR => self.dma_levels[0] = value & 0xf,
            IC_DMA_RDLR => self.dma_levels[1] = value & 0xf,
            IC_DMA_CR if value & 3 != 0 => return Written::ValueNotModelled,
            IC_DMA_CR | IC_INTR_STAT | IC_RAW_INTR_STAT | IC_STATUS | IC_TXFLR | IC_RXFLR => {}
            IC_TX_ABRT_SOURCE | IC_ENABLE_STATUS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// IC_DATA_CMD: until an abort has been cleared, what is written is thrown away.
    fn push(&mut self, value: u32, now: Ticks) {
        if !self.is_enabled() || self.abort_source != 0 {
            return;
        }
        if self.commands.len() >= FIFO_DEPTH {
            self.latched |= TX_OVER;
            return;
        }
        self.commands.push_back(Command {
            byte: value as u8,
            read: value & CMD_READ != 0,
            stop: value & CMD_STOP != 0,
            restart: value & CMD_RESTART != 0,
        });
        self.go_on(now);
    }

    fn write_enable(&mut self, value: u32, now: Ticks) {
        let was_enabled = self.is_enabled();
        self.enable = value & !ABORT;
        if was_enabled && value & ABORT != 0 && self.phase != Phase::Idle {
            self.abort(ABRT_USER_ABRT);
        }
        if !self.is_enabled() {
            self.commands.clear();
            self.received.clear();
            self.latched = 0;
        }
        self.go_on(now);
    }

    /// The interrupt line.
    pub fn interrupt(&self) -> bool {
        self.raw() & self.mask != 0
    }
}
