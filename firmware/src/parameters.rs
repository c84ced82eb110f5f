//! The board's parameters in flash: the last two sectors of 2 MiB, which `memory.x` leaves free.
//!
//! What is kept there, and why a power cut leaves the old or the new, is in
//! `pneudrive_control::store`.

use crate::{config, safe_state, shared};
use embassy_rp::Peri;
use embassy_rp::flash::{self, Blocking, ERASE_SIZE};
use embassy_rp::peripherals::FLASH;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Timer};
use pneudrive_control::store::{Flash, RECORD, SLOT, Slot};
use pneudrive_control::{BoardStart, ParameterSet};
use pneudrive_protocol::Address;

const FLASH_SIZE: usize = 2 * 1024 * 1024;
const FIRST_SLOT: usize = FLASH_SIZE - 2 * SLOT;
const _: () = assert!(SLOT == ERASE_SIZE && RECORD == flash::PAGE_SIZE);

/// Longer than flash takes at worst: 400 ms for a sector, 3 ms for a page (W25Q16JV datasheet,
/// 9.6).
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// The answer that a commit was taken is on the wire for 0.12 ms.
const ANSWER_TIME: Duration = Duration::from_millis(1);

/// The two sectors. The flash is read at start-up and written right before a restart, because
/// everything else runs from RAM.
pub struct ParameterFlash(flash::Flash<'static, FLASH, Blocking, FLASH_SIZE>);

impl ParameterFlash {
    /// The chip's flash.
    pub fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(flash::Flash::new_blocking(flash))
    }

    const fn offset(slot: Slot) -> u32 {
        (FIRST_SLOT + slot.index() * SLOT) as u32
    }
}

impl Flash for ParameterFlash {
    fn read(&self, slot: Slot) -> [u8; RECORD] {
        let start = flash::FLASH_BASE.cast::<u8>().wrapping_add(Self::offset(slot) as usize);
        // SAFETY: the chip's flash is mapped there, and nobody but `self`, which is borrowed,
        // writes to this part of it. Volatile, because a write changes what a read before has seen.
        core::array::from_fn(|n| unsafe { start.add(n).read_volatile() })
    }

    fn erase(&mut self, slot: Slot) -> bool {
        let start = Self::offset(slot);
        self.0.blocking_erase(start, start + SLOT as u32).is_ok()
    }

    fn program(&mut self, slot: Slot, record: &[u8; RECORD]) -> bool {
        self.0.blocking_write(Self::offset(slot), record).is_ok()
    }
}

/// What the board starts with.
pub struct Parameters {
    flash: ParameterFlash,
    start: BoardStart,
}

impl Parameters {
    /// What flash keeps, over what was compiled.
    pub fn load(flash: Peri<'static, FLASH>, switch: Address) -> Self {
        let flash = ParameterFlash::new(flash);
        let start = BoardStart::load(&flash, config::BOARD, switch);
        Self { flash, start }
    }

    /// The configuration and address in effect.
    pub fn start(&self) -> &BoardStart {
        &self.start
    }

    /// Does what a host has committed, if one has: keeps it and restarts, or says why not.
    pub async fn obey(&mut self, watchdog: &mut Watchdog) {
        let Some(set) = shared::with(|shared| shared.port.take_commit()) else { return };
        match self.start.check(&set) {
            Ok(()) => {
                Timer::after(ANSWER_TIME).await;
                self.keep_and_restart(&set, watchdog)
            }
            Err(refusal) => shared::with(|shared| shared.port.end_commit(refusal)),
        }
    }

    /// Nothing else runs meanwhile, the valve pins are at vent, and a flash that hangs ends by the
    /// watchdog. What the host cannot be told before the restart (that flash failed) it sees after
    /// it: the number of the record is the old one.
    fn keep_and_restart(&mut self, set: &ParameterSet, watchdog: &mut Watchdog) -> ! {
        cortex_m::interrupt::disable();
        safe_state::enter();
        watchdog.feed(WRITE_TIMEOUT);
        if self.start.keep(&mut self.flash, set).is_err() {
            defmt::error!("parameters could not be written");
        }
        watchdog.trigger_reset();
        loop {
            cortex_m::asm::nop();
        }
    }
}
