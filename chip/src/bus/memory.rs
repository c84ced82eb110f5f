//! The address map (2.2) and the accesses of core and DMA.

use super::Bus;
use super::flash::{XIP_CONTROL, XIP_CONTROL_END};
use super::registers::{ALIAS_BITS, has_interposer};
use crate::report::{Access, Concern, Fault};

/// The six SRAM banks, the first four striped (2.6.2).
const SRAM: u32 = 0x2000_0000;
pub(crate) const SRAM_SIZE: usize = 264 * 1024;

/// Peripherals behind the APB bridge from 0x4000_0000, on the AHB-Lite from 0x5000_0000.
const PERIPHERALS: u32 = 0x4000_0000;
const PERIPHERALS_END: u32 = 0x6000_0000;
/// The single-cycle IO port.
const SIO: u32 = 0xd000_0000;
const SIO_END: u32 = 0xd000_1000;
const ROM_END: u32 = 0x0000_4000;

/// What SRAM holds at power-on. The chip's content is random; a fixed pattern that is neither zero
/// nor a small number shows reads of memory that was never written.
const POWER_ON_BYTE: u8 = 0xa5;

pub(super) fn power_on_sram() -> Box<[u8; SRAM_SIZE]> {
    Box::new([POWER_ON_BYTE; SRAM_SIZE])
}

/// Cycles of an access to SRAM.
pub(crate) const RAM_CYCLES: u32 = 2;

/// Cycles of a load or store: two (TRM table 3-1), one at the single-cycle IO port. Behind the APB
/// bridge the bus takes three cycles for a read and four for a write instead of one (2.1.3), and
/// two more for an atomic write to a peripheral that has the aliases from an interposer (2.1.2).
#[inline]
pub(crate) fn access_cycles(address: u32, write: bool) -> u32 {
    match address >> 28 {
        0x4 if write && address & ALIAS_BITS != 0 && has_interposer(address) => 7,
        0x4 if write => 5,
        0x4 => 4,
        0xd => 1,
        _ => RAM_CYCLES,
    }
}

impl Bus {
    /// The bytes at an address in SRAM.
    #[inline]
    fn sram<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let start = address.wrapping_sub(SRAM) as usize;
        if start > SRAM_SIZE - N {
            return None;
        }
        self.sram[start..].first_chunk().copied()
    }

    /// Writes to SRAM; false if the address is elsewhere.
    #[inline]
    fn set_sram<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> bool {
        let start = address.wrapping_sub(SRAM) as usize;
        if start > SRAM_SIZE - N {
            return false;
        }
        self.sram[start..start + N].copy_from_slice(&bytes);
        true
    }

    /// The bytes at an address in SRAM that is a multiple of their number.
    #[inline]
    pub fn aligned_sram<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        if (address as usize).is_multiple_of(N) { self.sram(address) } else { None }
    }

    /// Writes to an address in SRAM that is a multiple of the number of bytes; false if it is none.
    #[inline]
    pub fn set_aligned_sram<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> bool {
        (address as usize).is_multiple_of(N) && self.set_sram(address, bytes)
    }

    #[inline]
    fn memory<const N: usize>(&mut self, address: u32) -> Option<[u8; N]> {
        self.sram(address).or_else(|| self.read_flash(address))
    }

    /// An instruction; none where there is no memory.
    #[inline]
    pub fn fetch(&mut self, address: u32) -> Option<u16> {
        match self.sram(address) {
            Some(bytes) => Some(u16::from_le_bytes(bytes)),
            None => self.fetch_flash(address),
        }
    }

    /// The same, and none if flash must be waited for ([`Bus::must_wait`]): the next time it is
    /// there.
    #[inline]
    pub fn fetch_at_once(&mut self, address: u32) -> Option<u16> {
        match self.sram(address) {
            Some(bytes) => Some(u16::from_le_bytes(bytes)),
            None => self.fetch_flash(address).filter(|_| !self.must_wait()),
        }
    }

    #[inline]
    pub fn read32(&mut self, address: u32) -> Result<u32, Fault> {
        if address & 3 != 0 {
            return Err(Fault::Unaligned(address));
        }
        if let PERIPHERALS..PERIPHERALS_END = address {
            return Ok(self.read_register(address));
        }
        match self.memory(address) {
            Some(bytes) => Ok(u32::from_le_bytes(bytes)),
            None => self.read_device(address),
        }
    }

    #[inline]
    pub fn read16(&mut self, address: u32) -> Result<u16, Fault> {
        if address & 1 != 0 {
            return Err(Fault::Unaligned(address));
        }
        match self.memory(address) {
            Some(bytes) => Ok(u16::from_le_bytes(bytes)),
            None => Ok((self.read_device(address & !3)? >> (8 * (address & 2))) as u16),
        }
    }

    #[inline]
    pub fn read8(&mut self, address: u32) -> Result<u8, Fault> {
        match self.memory(address) {
            Some([byte]) => Ok(byte),
            None => Ok((self.read_device(address & !3)? >> (8 * (address & 3))) as u8),
        }
    }

    #[inline]
    pub fn write32(&mut self, address: u32, value: u32) -> Result<(), Fault> {
        if address & 3 != 0 {
            return Err(Fault::Unaligned(address));
        }
        if self.set_sram(address, value.to_le_bytes()) {
            return Ok(());
        }
        self.write_device(address, value)
    }

    /// A narrow write to a peripheral puts the value on all lanes: the register is written as a
    /// whole (2.1.4).
    #[inline]
    pub fn write16(&mut self, address: u32, value: u16) -> Result<(), Fault> {
        if address & 1 != 0 {
            return Err(Fault::Unaligned(address));
        }
        if self.set_sram(address, value.to_le_bytes()) {
            return Ok(());
        }
        self.write_device(address & !3, u32::from(value) * 0x0001_0001)
    }

    #[inline]
    pub fn write8(&mut self, address: u32, value: u8) -> Result<(), Fault> {
        if self.set_sram(address, [value]) {
            return Ok(());
        }
        self.write_device(address & !3, u32::from(value) * 0x0101_0101)
    }

    /// Peripherals catch up with time only where a register has to do with it: programs poll
    /// others.
    fn read_device(&mut self, address: u32) -> Result<u32, Fault> {
        match address {
            PERIPHERALS..PERIPHERALS_END => Ok(self.read_register(address)),
            SIO..SIO_END => {
                self.catch_up();
                Ok(self.read_sio(address))
            }
            XIP_CONTROL..XIP_CONTROL_END => {
                self.catch_up();
                Ok(self.read_flash_register(address))
            }
            // There is no boot ROM image, but its table of functions.
            0..ROM_END => {
                if let Some(word) = Bus::read_rom(address) {
                    return Ok(word);
                }
                self.note_unmodelled(address, Access::Read, Concern::NotModelled);
                Ok(0)
            }
            _ => Err(Fault::Bus(address)),
        }
    }

    fn write_device(&mut self, address: u32, value: u32) -> Result<(), Fault> {
        self.catch_up();
        match address {
            SIO..SIO_END => self.write_sio(address, value),
            PERIPHERALS..PERIPHERALS_END => self.write_register(address, value),
            XIP_CONTROL..XIP_CONTROL_END => self.write_flash_register(address, value),
            _ if Bus::is_flash(address) => return self.write_flash(address),
            _ => return Err(Fault::Bus(address)),
        }
        Ok(())
    }

    /// A byte of flash or SRAM without side effects.
    pub fn peek(&self, address: u32) -> Option<u8> {
        self.sram(address).or_else(|| self.flash(address)).map(|[byte]| byte)
    }

    /// Copies a program's initial RAM contents, or a test's.
    pub fn load_sram(&mut self, address: u32, bytes: &[u8]) -> Result<(), Fault> {
        let start = address.wrapping_sub(SRAM) as usize;
        match self.sram.get_mut(start..).and_then(|sram| sram.get_mut(..bytes.len())) {
            Some(target) => {
                target.copy_from_slice(bytes);
                Ok(())
            }
            None => Err(Fault::Bus(address)),
        }
    }
}
