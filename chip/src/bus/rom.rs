//! The boot ROM's functions (2.8.3) that change flash, and the table by which programs find them.
//! There is no image of the ROM: a call does at once what the function does, and the processor
//! waits for as long as the flash chip takes.

use std::sync::Arc;

use super::Bus;
use super::flash::XIP_OFFSET;
use crate::peripherals::ssi::Ssi;
use crate::report::{Access, Concern, Fault};
use crate::ticks::Ticks;

/// Where programs look (2.8.3.1): magic with version 2 behind it, then 16-bit pointers to the
/// tables and to the function that searches them.
const MAGIC: u32 = 0x10;
const TABLES: u32 = 0x14;
const LOOKUP: u32 = 0x18;
const FUNCTION_TABLE: u32 = 0x100;
const FUNCTIONS: u32 = 0x200;

/// Functions by their codes, in the order of their places from [`FUNCTIONS`] on, four bytes each;
/// the search comes first and has none.
const CODES: [[u8; 2]; 7] = [*b"C4", *b"IF", *b"EX", *b"RE", *b"RP", *b"FC", *b"CX"];
const NAMES: [Function; 8] = [
    Function::Lookup,
    Function::Copy,
    Function::ConnectFlash,
    Function::ExitXip,
    Function::Erase,
    Function::Program,
    Function::FlushCache,
    Function::EnterXip,
];

#[derive(Clone, Copy, Debug)]
enum Function {
    Lookup,
    Copy,
    ConnectFlash,
    ExitXip,
    Erase,
    Program,
    FlushCache,
    EnterXip,
}

const SECTOR: usize = 4096;
const PAGE: usize = 256;
/// Typical times of the W25Q16JV (datasheet 9.6): a sector erase, and a page program.
const SECTOR_ERASE: Ticks = Ticks::from_millis(45);
const PAGE_PROGRAM: Ticks = Ticks::from_micros(400);

/// A change of flash that is going on, or the last one. What it changes is in flash already; a
/// power cut puts part of it back.
#[derive(Clone, Debug)]
pub(super) struct FlashChange {
    offset: usize,
    before: Vec<u8>,
    begin: Ticks,
    end: Ticks,
}

impl Bus {
    /// A word of the ROM's tables.
    pub(super) fn read_rom(address: u32) -> Option<u32> {
        let place = |number: u32| FUNCTIONS + 4 * number + 1;
        match address {
            MAGIC => Some(u32::from_le_bytes([b'M', b'u', 1, 2])),
            // Both tables: there is no data.
            TABLES => Some(FUNCTION_TABLE | (FUNCTION_TABLE + 4 * CODES.len() as u32) << 16),
            LOOKUP => Some(place(0)),
            _ => {
                let number = address.checked_sub(FUNCTION_TABLE)? / 4;
                let end = (number == CODES.len() as u32).then_some(0);
                let code = CODES.get(number as usize).map(|code| u32::from(u16::from_le_bytes(*code)));
                code.map(|code| code | place(number + 1) << 16).or(end)
            }
        }
    }

    /// A call of the function at `pc`; gives what it returns in R0. `None` if there is no function.
    pub(crate) fn call_rom(&mut self, pc: u32, arguments: [u32; 4]) -> Option<Result<u32, Fault>> {
        let place = pc.checked_sub(FUNCTIONS).filter(|place| place.is_multiple_of(4))?;
        let function = NAMES.get((place / 4) as usize)?;
        self.catch_up();
        let [first, second, third, _] = arguments;
        Some(match function {
            Function::Lookup => Ok(Self::look_up(second)),
            Function::Copy => self.copy(first, second, third),
            Function::ConnectFlash => Ok(0),
            Function::ExitXip => {
                self.ssi = Ssi::after_boot_rom();
                Ok(0)
            }
            Function::Erase => {
                self.erase(first as usize, second as usize, pc);
                Ok(0)
            }
            Function::Program => self.program(first as usize, second, third as usize, pc).map(|()| 0),
            Function::FlushCache => {
                self.flush_cache();
                Ok(0)
            }
            Function::EnterXip => {
                self.note_unmodelled(pc, Access::Read, Concern::NotModelled);
                Ok(0)
            }
        })
    }

    /// The function with this code, or 0 as the ROM's search.
    fn look_up(code: u32) -> u32 {
        let wanted = code.to_le_bytes();
        let found = (0..).zip(CODES).find(|(_, code)| wanted == [code[0], code[1], 0, 0]);
        found.map_or(0, |(number, _)| FUNCTIONS + 4 * (number + 1) + 1)
    }

    fn copy(&mut self, to: u32, from: u32, bytes: u32) -> Result<u32, Fault> {
        for offset in (0..bytes).step_by(4) {
            let word = self.read32(from + offset)?;
            self.write32(to + offset, word)?;
        }
        Ok(to)
    }

    fn erase(&mut self, offset: usize, bytes: usize, pc: u32) {
        let sectors = bytes / SECTOR;
        if !offset.is_multiple_of(SECTOR) || sectors * SECTOR != bytes {
            return self.note_unmodelled(pc, Access::Write, Concern::ValueNotModelled);
        }
        let took = Ticks::new(SECTOR_ERASE.get() * sectors as u64);
        self.change_flash(offset, vec![0xff; bytes], took, pc);
    }

    fn program(&mut self, offset: usize, from: u32, bytes: usize, pc: u32) -> Result<(), Fault> {
        let pages = bytes / PAGE;
        if !offset.is_multiple_of(PAGE) || pages * PAGE != bytes {
            self.note_unmodelled(pc, Access::Write, Concern::ValueNotModelled);
            return Ok(());
        }
        let data = (0..bytes as u32).map(|n| self.read8(from + n)).collect::<Result<Vec<u8>, Fault>>()?;
        // It can only clear bits.
        let old = self.flash.get(offset..).unwrap_or_default().iter().copied().chain(std::iter::repeat(0xff));
        let result = data.iter().zip(old).map(|(new, old)| new & old).collect();
        self.change_flash(offset, result, Ticks::new(PAGE_PROGRAM.get() * pages as u64), pc);
        Ok(())
    }

    fn change_flash(&mut self, offset: usize, after: Vec<u8>, takes: Ticks, pc: u32) {
        let end = offset + after.len();
        // A chip in continuous reads takes an instruction for an address.
        if end > XIP_OFFSET as usize + 1 || !self.ssi.flash_takes_instructions() {
            return self.note_unmodelled(pc, Access::Write, Concern::ValueNotModelled);
        }
        if self.flash.len() < end {
            let mut longer = self.flash.to_vec();
            longer.resize(end, 0xff);
            self.flash = longer.into();
        }
        let place = &mut Arc::make_mut(&mut self.flash)[offset..end];
        let before = place.to_vec();
        place.copy_from_slice(&after);
        let change = FlashChange { offset, before, begin: self.now, end: self.now + takes };
        self.flash_change = Some(change);
        self.pause_core();
    }

    /// When the flash chip has done, or will have done, what it was last told to; zero if it was
    /// told nothing since power-on.
    pub fn flash_busy_until(&self) -> Ticks {
        self.flash_change.as_ref().map_or(Ticks::ZERO, |change| change.end)
    }

    /// The supply ends: of what is going on, as many bits have changed as of its time has passed.
    /// Which ones is anybody's guess, and here the same for the same place.
    pub(super) fn cut_flash(&mut self) {
        let now = self.now;
        let Some(change) = self.flash_change.take().filter(|change| now < change.end) else { return };
        let done = now.saturating_sub(change.begin).get();
        let all = change.end.saturating_sub(change.begin).get();
        let flash = Arc::make_mut(&mut self.flash);
        for (n, before) in change.before.iter().enumerate() {
            let Some(byte) = flash.get_mut(change.offset + n) else { continue };
            for bit in 0..8 {
                let turn = (8 * n as u32 + bit).wrapping_mul(0x9E37_79B1) >> 16;
                if u64::from(turn) * all >= done << 16 {
                    *byte = *byte & !(1 << bit) | before & 1 << bit;
                }
            }
        }
    }
}
