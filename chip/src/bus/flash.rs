//! Flash through its cache: what an access brings, and how long the processor waits for it.

use super::Bus;
use crate::peripherals::ssi::Ssi;
use crate::peripherals::xip::FLUSH_CYCLES;
use crate::peripherals::{RegisterWrite, Written};
use crate::report::{Access, Concern, Fault};
use crate::ticks::Ticks;

/// Flash through the cache, and its three aliases that differ in caching only.
const XIP: u32 = 0x1000_0000;
const XIP_END: u32 = 0x1400_0000;
pub(super) const XIP_OFFSET: u32 = 0x00ff_ffff;
/// XIP_CTRL with its atomic aliases, and the SSI, which has none.
pub(super) const XIP_CONTROL: u32 = 0x1400_0000;
const XIP_CONTROL_REGISTERS_END: u32 = 0x1400_4000;
const SSI: u32 = 0x1800_0000;
const SSI_END: u32 = 0x1800_0100;
pub(super) const XIP_CONTROL_END: u32 = 0x2000_0000;

/// No word has this address.
const NOTHING_FETCHED: u32 = 1;

/// The processor's side of flash.
#[derive(Clone, Debug)]
pub(super) struct FlashPort {
    /// Cycles that the processor must still spend waiting.
    wait_cycles: u32,
    /// The word that was fetched last: instructions come two at a time, one word ahead of the one
    /// being executed.
    fetched: u32,
}

impl Default for FlashPort {
    fn default() -> Self {
        FlashPort { wait_cycles: 0, fetched: NOTHING_FETCHED }
    }
}

impl Bus {
    /// The bytes at an address in flash. What the image does not fill reads as erased flash.
    #[inline]
    pub(super) fn flash<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        if !(XIP..XIP_END).contains(&address) {
            return None;
        }
        let start = (address & XIP_OFFSET) as usize;
        Some(self.flash.get(start..).and_then(|f| f.first_chunk().copied()).unwrap_or([0xff; N]))
    }

    /// The same as data for the processor.
    #[inline]
    pub(super) fn read_flash<const N: usize>(&mut self, address: u32) -> Option<[u8; N]> {
        let bytes = self.flash(address)?;
        self.access_flash(address & !3);
        Some(bytes)
    }

    /// An instruction. The processor fetches words, the next one while it executes the upper half
    /// of this one: so a branch there has fetched (and waited for) one word that it does not need.
    /// A word is counted once, also if a branch fetches it again.
    #[inline]
    pub(super) fn fetch_flash(&mut self, address: u32) -> Option<u16> {
        let bytes = self.flash(address)?;
        let ahead = address.wrapping_add(2) & !3;
        if self.flash_port.fetched != ahead {
            self.fetch_words(address & !3, ahead);
        }
        Some(u16::from_le_bytes(bytes))
    }

    #[inline]
    fn fetch_words(&mut self, word: u32, ahead: u32) {
        if self.flash_port.fetched != word && ahead != word {
            self.access_flash(word);
        }
        self.access_flash(ahead);
        self.flash_port.fetched = ahead;
    }

    #[inline]
    fn access_flash(&mut self, word: u32) {
        if !self.xip.access(word) {
            self.miss(word);
        }
    }

    #[cold]
    fn miss(&mut self, word: u32) {
        self.catch_up();
        if !self.ssi.can_read() {
            self.note_unmodelled(word, Access::Read, Concern::ValueNotModelled);
        }
        let flushing = self.xip.flushed_at().saturating_sub(self.now);
        let flushing = self.processor_rate().counts_in(flushing) as u32;
        self.flash_port.wait_cycles += self.ssi.read_cycles() + flushing;
        self.stop_core();
    }

    /// Whether the processor must wait for flash.
    #[inline]
    pub fn must_wait(&self) -> bool {
        self.flash_port.wait_cycles != 0
    }

    /// The cycles for which the processor must wait for flash, once.
    pub(super) fn take_wait_cycles(&mut self) -> u32 {
        std::mem::take(&mut self.flash_port.wait_cycles)
    }

    /// The processor waits for flash as long as it must.
    pub fn spend_waits(&mut self) {
        let cycles = self.take_wait_cycles();
        self.spend_cycles(cycles);
    }

    pub(super) fn set_wait_cycles(&mut self, cycles: u32) {
        self.flash_port.wait_cycles = cycles;
    }

    /// Writing to flash addresses gives up entries of the cache, and changes no flash.
    pub(super) fn write_flash(&mut self, address: u32) -> Result<(), Fault> {
        if self.xip.invalidate(address) { Ok(()) } else { Err(Fault::Bus(address)) }
    }

    pub(super) fn is_flash(address: u32) -> bool {
        (XIP..XIP_END).contains(&address)
    }

    /// A register of XIP_CTRL or the SSI.
    pub(super) fn read_flash_register(&mut self, address: u32) -> u32 {
        let now = self.now;
        let value = match address {
            XIP_CONTROL..XIP_CONTROL_REGISTERS_END => self.xip.read(address & 0xfff, now),
            SSI..SSI_END => self.ssi.read(address & 0xff, now),
            _ => None,
        };
        value.unwrap_or_else(|| {
            self.note_unmodelled(address, Access::Read, Concern::NotModelled);
            0
        })
    }

    pub(super) fn write_flash_register(&mut self, address: u32, value: u32) {
        let (now, clk_sys) = (self.now, self.processor_rate());
        let written = match address {
            XIP_CONTROL..XIP_CONTROL_REGISTERS_END => {
                let flushed = self.now + clk_sys.ticks_for(FLUSH_CYCLES);
                self.xip.write(address & 0xfff, RegisterWrite::new(address, value), flushed)
            }
            SSI..SSI_END => self.ssi.write(address & 0xff, RegisterWrite::plain(value), clk_sys, now),
            _ => Written::NotModelled,
        };
        let concern = match written {
            Written::Done => return,
            Written::NotModelled => Concern::NotModelled,
            Written::ValueNotModelled => Concern::ValueNotModelled,
        };
        self.note_unmodelled(address, Access::Write, concern);
    }

    /// Cache and SSI as a start of the processor finds them: the boot ROM has used flash before,
    /// and if there is no boot loader in it, one like the W25Q080's is taken to have run.
    pub fn restart_flash(&mut self, boot_loader_will_run: bool) {
        self.ssi = if boot_loader_will_run { Ssi::after_boot_rom() } else { Ssi::after_boot_loader() };
        self.flush_cache();
        self.flash_port = FlashPort::default();
    }

    /// Empties the cache at once.
    pub fn flush_cache(&mut self) {
        self.xip.flush(Ticks::ZERO);
        self.flash_port.fetched = NOTHING_FETCHED;
    }

    /// Words of flash that have been accessed since CTR_ACC was last cleared, and of these the ones
    /// found in the cache.
    pub fn flash_accesses(&self) -> (u32, u32) {
        self.xip.counters()
    }
}
