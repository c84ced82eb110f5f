//! Updates over the bus: a new program collects in RAM, is checked, and goes into the place that
//! the running one is not in.
//!
//! While flash is written nothing else runs, and the valve pins are at vent, as for parameters.

use crate::chip::places::{
    CHOICE, DAMAGED, FIRST_PLACE, FLASH, NOT_CONFIRMED, PLACE, SCRATCH, SECTOR, State,
};
use crate::inbox::received;
use crate::{chip, safe_state, shared};
use embassy_rp::flash::{self, Blocking, PAGE_SIZE};
use embassy_rp::peripherals;
use embassy_rp::watchdog::Watchdog;
use embassy_time::{Duration, Instant, Timer};
use pneudrive_control::update::choice::{Choice, RECORD};
use pneudrive_control::update::{RunningProgram, UpdateOrder, check};
use pneudrive_control::{BusPort, Micros};
use pneudrive_protocol::pages::{LastTrial, Running, Update};
use pneudrive_protocol::program::{Program, crc};

const FLASH_SIZE: usize = 2 * 1024 * 1024;
const PAGE: usize = PAGE_SIZE;

/// Longer than a sector or a page takes at worst: 400 ms and 3 ms (W25Q16JV datasheet, 9.6).
const STEP_TIMEOUT: Duration = Duration::from_secs(2);
/// The answer that a commit was taken is on the wire for 0.12 ms.
const ANSWER_TIME: Duration = Duration::from_millis(1);
const TRIAL: Duration = Duration::from_secs(Update::TRIAL_S);

/// What the board knows of its program.
pub struct Updates {
    program: RunningProgram,
    length: u32,
}

impl Updates {
    /// What the boot stage has left.
    pub fn at_start() -> Self {
        let [state, length, crc, trial] = SCRATCH.map(read);
        let running = match state {
            first if first == State::CONFIRMED => Running::First,
            second if second == State::CONFIRMED | 1 => Running::Second,
            first if first == State::TRIAL => Running::TrialFirst,
            second if second == State::TRIAL | 1 => Running::TrialSecond,
            _ => Running::Flashed,
        };
        let last_trial = match trial {
            DAMAGED => LastTrial::Damaged,
            NOT_CONFIRMED => LastTrial::NotConfirmed,
            _ => LastTrial::None,
        };
        let crc = if running == Running::Flashed { 0 } else { crc };
        Self { program: RunningProgram { running, last_trial, crc }, length }
    }

    /// Tells the board's pages.
    pub fn tell(&self, port: &mut BusPort) {
        port.support_updates(self.program);
    }

    /// How long the board vents after its start, at the least: as long as a program is on trial.
    pub fn vent(&self) -> Micros {
        if self.program.running.is_trial() {
            Micros::new((Update::TRIAL_S + 1) * 1_000_000)
        } else {
            Micros::ZERO
        }
    }

    /// The place that this program runs from.
    fn place(&self) -> u32 {
        u32::from(matches!(self.program.running, Running::Second | Running::TrialSecond))
    }

    /// Does what a host wants, if it wants something, and ends a trial that nobody has confirmed.
    pub async fn obey(&mut self, watchdog: &mut Watchdog) {
        if let Some(order) = shared::with(|shared| shared.port.take_update()) {
            // The check takes up to 0.1 s, and only the thread waits for it.
            watchdog.feed(STEP_TIMEOUT);
            match order {
                UpdateOrder::Try { received: length } => match check(received(length), chip::KIND) {
                    Ok(program) => {
                        Timer::after(ANSWER_TIME).await;
                        self.write_and_try(received(program.length), received(length), watchdog)
                    }
                    Err(refusal) => shared::with(|shared| shared.port.end_update(refusal)),
                },
                UpdateOrder::Keep => {
                    Timer::after(ANSWER_TIME).await;
                    self.keep_and_restart(watchdog)
                }
            }
        } else if self.program.running.is_trial() && Instant::now() > Instant::MIN + TRIAL {
            defmt::error!("nobody has confirmed this program: back to the one before");
            restart(watchdog)
        }
    }

    /// The new program into the other place; the boot stage tries it if all of it is there.
    fn write_and_try(&self, program: &[u8], received: &[u8], watchdog: &mut Watchdog) -> ! {
        alone();
        let place = self.place() ^ 1;
        let start = FIRST_PLACE + place * PLACE - FLASH;
        let crc = received.get(program.len()..).and_then(|rest| rest.first_chunk()).copied();
        let mut flash = Flash::new();
        let mut written = true;
        for (sector, bytes) in (start..).step_by(SECTOR as usize).zip(program.chunks(SECTOR as usize)) {
            watchdog.feed(STEP_TIMEOUT);
            written &= flash.erase(sector);
            for (page, bytes) in (sector..).step_by(PAGE).zip(bytes.chunks(PAGE)) {
                watchdog.feed(STEP_TIMEOUT);
                written &= flash.program(page, bytes);
            }
        }
        // What flash holds, the boot stage checks.
        let words = match crc {
            Some(crc) if written => [State::TRY | place, program.len() as u32, u32::from_le_bytes(crc), 0],
            _ => [0, 0, 0, DAMAGED],
        };
        leave(words);
        restart(watchdog)
    }

    /// This program from now on. The one before stays named by the other record, for the day on
    /// which flash has lost this one; the first update therefore writes two.
    fn keep_and_restart(&self, watchdog: &mut Watchdog) -> ! {
        alone();
        watchdog.feed(STEP_TIMEOUT);
        let records = [CHOICE, CHOICE + SECTOR].map(|at| Choice::decode(&record(at)));
        let number = |n: usize| records[n].map_or(0, |choice| choice.number);
        let mut older = u32::from(number(1) < number(0));
        let mut newest = number(0).max(number(1));
        let mut kept = true;
        if newest == 0
            && self.place() == 1
            && let Some(flashed) = flashed()
        {
            newest = flashed.number;
            kept = keep(older, &flashed);
            older = 1;
        }
        watchdog.feed(STEP_TIMEOUT);
        let (place, length, crc) = (self.place(), self.length, self.program.crc);
        kept = kept && keep(older, &Choice { number: newest.saturating_add(1), place, length, crc });
        if kept {
            // Else the boot stage finds that the trial has not ended well.
            leave([0; 4]);
        }
        restart(watchdog)
    }
}

/// The program that was flashed, as a record names it.
fn flashed() -> Option<Choice> {
    let start = FIRST_PLACE as *const u8;
    // SAFETY: flash is mapped there, and this program runs from RAM and came from the second place.
    let place = unsafe { core::slice::from_raw_parts(start, PLACE as usize) };
    let length = Program::parse(place).ok()?.length;
    Some(Choice { number: 1, place: 0, length: length as u32, crc: crc(place.get(..length)?) })
}

/// Writes one of the two records; whether it is there now.
fn keep(sector: u32, choice: &Choice) -> bool {
    let at = CHOICE - FLASH + SECTOR * sector;
    let mut flash = Flash::new();
    flash.erase(at) && flash.program(at, &choice.encode()) && record(FLASH + at) == choice.encode()
}

/// From here on nothing else runs, and the valves vent.
fn alone() {
    cortex_m::interrupt::disable();
    safe_state::enter();
}

fn restart(watchdog: &mut Watchdog) -> ! {
    watchdog.trigger_reset();
    loop {
        cortex_m::asm::nop();
    }
}

/// For the boot stage.
fn leave(words: [u32; 4]) {
    for (register, word) in SCRATCH.into_iter().zip(words) {
        // SAFETY: scratch registers, which only the boot stage and this module use.
        unsafe { (register as *mut u32).write_volatile(word) };
    }
}

fn read(address: u32) -> u32 {
    // SAFETY: a scratch register.
    unsafe { (address as *const u32).read_volatile() }
}

/// A page of flash as it is now.
fn record(address: u32) -> [u8; RECORD] {
    let start = address as *const u8;
    // SAFETY: flash is mapped there. Volatile, because a write changes what a read before has seen.
    core::array::from_fn(|n| unsafe { start.add(n).read_volatile() })
}

/// Flash, for as long as nothing else runs.
struct Flash(flash::Flash<'static, peripherals::FLASH, Blocking, FLASH_SIZE>);

impl Flash {
    fn new() -> Self {
        // SAFETY: the parameters have the other one, and belong to the same task, which is here
        // now.
        Self(flash::Flash::new_blocking(unsafe { peripherals::FLASH::steal() }))
    }

    fn erase(&mut self, sector: u32) -> bool {
        self.0.blocking_erase(sector, sector + SECTOR).is_ok()
    }

    /// At most a page; the rest of it as erased.
    fn program(&mut self, page: u32, bytes: &[u8]) -> bool {
        let mut whole = [0xff; PAGE];
        for (slot, byte) in whole.iter_mut().zip(bytes) {
            *slot = *byte;
        }
        self.0.blocking_write(page, &whole).is_ok()
    }
}
