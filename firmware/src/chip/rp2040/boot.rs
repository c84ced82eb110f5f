//! The boot stage: chooses a program, copies it to RAM, checks it there, and starts it.
//!
//! ```text
//!  flash    0x10000100  boot stage: never written by an update
//!           0x10002000  choice: two records, the newest counts
//!           0x10004000  first place: as flashed, or an update
//!           0x10024000  second place: an update
//! ```
//!
//! It writes no flash. A program on trial is named in a scratch register only, and that is cleared
//! before anything else happens: whatever becomes of the trial, the next reset starts what the
//! records name. So there is no moment at which the supply may not fail, and no program that can
//! keep the old one from coming back, except one that runs and is confirmed.
//!
//! The valve pins are high already (`start.rs`). Nothing here may call or read what lies in RAM,
//! where no program is yet: no function of another crate, no panic, no copying by a library.
//! Registers and memory are read and written one word at a time, volatile, which the compiler
//! leaves alone. `tests/tests/firmware/memory.rs` looks at what it made of it.

use super::places::{CHOICE, DAMAGED, FIRST_PLACE, NOT_CONFIRMED, PLACE, RAM, SCRATCH, SECTOR, State};
use pneudrive_control::update::choice;
use pneudrive_protocol::program::{HEADER_AT, LONGEST, MAGIC};

/// What a place must hold to be started.
const RP2040: u32 = 1;
/// RAM ends there; the stack pointers of boot stage and programs begin below.
const RAM_END: u32 = 0x2004_0000;
/// Words of a record before its CRC.
const RECORD_CRC_AT: u32 = 20;
const VTOR: u32 = 0xe000_ed08;

/// A trial that hangs before it starts the watchdog itself, which it does within 0.2 s, ends after
/// so long, us.
const TRIAL_WATCHDOG_US: u32 = 2_000_000;
/// The watchdog counts twice a microsecond (RP2040-E1).
const WATCHDOG_LOAD: u32 = 2 * TRIAL_WATCHDOG_US;
/// WATCHDOG: CTRL, LOAD, TICK; PSM: WDSEL.
const WATCHDOG_CTRL: u32 = 0x4005_8000;
const WATCHDOG_LOAD_AT: u32 = 0x4005_8004;
const WATCHDOG_TICK: u32 = 0x4005_802c;
const PSM_WDSEL: u32 = 0x4001_0008;
/// All but the oscillators, as Embassy has it.
const RESET_BY_WATCHDOG: u32 = 0x1fffc;
/// A tick in 17 cycles of the ring oscillator, which `start.rs` has set to 17 MHz.
const TICK: u32 = 1 << 9 | 17;
const ENABLE: u32 = 1 << 30;

/// Called by `start.rs` with the stack at the end of RAM.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".Reset")]
unsafe extern "C" fn choose_program() -> ! {
    // SAFETY: nothing else runs, and nothing in RAM is in use but the stack, which no program
    // reaches.
    unsafe {
        let state = read(SCRATCH[0]);
        let (length, crc) = (read(SCRATCH[1]), read(SCRATCH[2]));
        write(SCRATCH[0], 0);
        if state & !1 == State::TRIAL {
            write(SCRATCH[3], NOT_CONFIRMED);
        }
        if state & !1 == State::TRY {
            if load(state & 1, length, crc) {
                write(SCRATCH[0], State::TRIAL | state & 1);
                start_watchdog();
                run();
            }
            write(SCRATCH[3], DAMAGED);
        }
        run_chosen()
    }
}

/// Of the two records the newer one, then the older one; without any record the program that was
/// flashed.
#[inline(always)]
unsafe fn run_chosen() -> ! {
    // SAFETY: as above.
    unsafe {
        let (first, second) = (CHOICE, CHOICE + SECTOR);
        let (first_is_one, second_is_one) = (is_record(first), is_record(second));
        let second_is_newer = second_is_one && (!first_is_one || read(second + 4) > read(first + 4));
        let (newer, older) = if second_is_newer { (second, first) } else { (first, second) };
        if first_is_one || second_is_one {
            run_recorded(newer);
        }
        if first_is_one && second_is_one {
            run_recorded(older);
        }
        // What a probe or the boot ROM has flashed they have checked; once there is a record, this
        // place may hold anything.
        let length = read(FIRST_PLACE + HEADER_AT as u32 + 4);
        if !first_is_one && !second_is_one && fits(length) {
            copy(FIRST_PLACE, length);
            if is_program(length) {
                write(SCRATCH[0], State::FLASHED);
                run();
            }
        }
        // Nothing to start. The valves vent; the boot ROM or a probe can flash the board.
        loop {
            core::arch::asm!("wfi");
        }
    }
}

/// Starts what this record names, if that is there.
#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn run_recorded(record: u32) {
    // SAFETY: the caller's.
    unsafe {
        let (place, length, crc) = (read(record + 8), read(record + 12), read(record + 16));
        if load(place, length, crc) {
            write(SCRATCH[1], length);
            write(SCRATCH[2], crc);
            write(SCRATCH[0], State::CONFIRMED | place);
            run();
        }
    }
}

#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn is_record(at: u32) -> bool {
    // SAFETY: reads flash.
    unsafe {
        read(at) == choice::FORMAT
            && checksum(at, RECORD_CRC_AT) == read(at + RECORD_CRC_AT)
            && read(at + 8) < 2
    }
}

/// Copies the program in this place to RAM; whether it is there what it should be.
#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn load(place: u32, length: u32, crc: u32) -> bool {
    if !fits(length) {
        return false;
    }
    // SAFETY: the caller has nothing in RAM but the stack.
    unsafe {
        copy(FIRST_PLACE + place * PLACE, length);
        checksum(RAM, length) == crc && is_program(length)
    }
}

#[inline(always)]
fn fits(length: u32) -> bool {
    length > HEADER_AT as u32 + 16 && length <= LONGEST as u32 && length & 3 == 0
}

/// Whether what has been copied is a program of this length for this chip.
#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn is_program(length: u32) -> bool {
    // SAFETY: reads RAM.
    unsafe {
        let header = RAM + HEADER_AT as u32;
        let (stack_pointer, entry) = (read(RAM), read(RAM + 4));
        read(header) == MAGIC
            && read(header + 4) == length
            && read(header + 8) == RP2040
            && stack_pointer <= RAM_END
            && stack_pointer >= RAM + length
            && entry & 1 == 1
            && entry >= RAM
            && entry < RAM + length
    }
}

#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn copy(from: u32, length: u32) {
    let mut offset = 0;
    while offset < length {
        // SAFETY: the caller's: flash, and RAM up to the longest program.
        unsafe { write(RAM + offset, read(from + offset)) };
        offset += 4;
    }
}

/// CRC-32 (ISO-HDLC) of words. Its table lies in flash, and in the cache after the first few
/// hundred bytes.
#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn checksum(from: u32, length: u32) -> u32 {
    let table = (&raw const TABLE).cast::<u32>();
    let mut crc = u32::MAX;
    let mut offset = 0;
    while offset < length {
        // SAFETY: the caller's; and the table has an entry for every byte.
        unsafe {
            crc ^= read(from + offset);
            crc = crc >> 8 ^ table.add((crc & 0xff) as usize).read_volatile();
            crc = crc >> 8 ^ table.add((crc & 0xff) as usize).read_volatile();
            crc = crc >> 8 ^ table.add((crc & 0xff) as usize).read_volatile();
            crc = crc >> 8 ^ table.add((crc & 0xff) as usize).read_volatile();
        }
        offset += 4;
    }
    !crc
}

#[unsafe(link_section = ".boot_data")]
static TABLE: [u32; 256] = table();

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = crc >> 1 ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
}

#[inline(always)]
unsafe fn start_watchdog() {
    // SAFETY: registers that nobody else uses now.
    unsafe {
        write(PSM_WDSEL, RESET_BY_WATCHDOG);
        write(WATCHDOG_TICK, TICK);
        write(WATCHDOG_LOAD_AT, WATCHDOG_LOAD);
        write(WATCHDOG_CTRL, ENABLE);
    }
}

/// Starts what has been copied. Its HardFault comes here first: see [`fault`](super::fault).
#[inline(never)]
#[unsafe(link_section = ".Reset")]
unsafe fn run() -> ! {
    // SAFETY: a program that has been found to be one. Its own handler moves to an entry that the
    // processor never uses.
    unsafe {
        write(RAM + super::fault::PROGRAMS_HANDLER, read(RAM + super::fault::HANDLER));
        write(RAM + super::fault::HANDLER, super::fault::boot_hard_fault as *const () as u32);
        write(VTOR, RAM);
        core::arch::asm!(
            "dsb",
            "msr msp, {stack_pointer}",
            "isb",
            "bx {entry}",
            stack_pointer = in(reg) read(RAM),
            entry = in(reg) read(RAM + 4),
            options(noreturn),
        )
    }
}

#[inline(always)]
unsafe fn read(address: u32) -> u32 {
    // SAFETY: the caller's.
    unsafe { (address as *const u32).read_volatile() }
}

#[inline(always)]
unsafe fn write(address: u32, value: u32) {
    // SAFETY: the caller's.
    unsafe { (address as *mut u32).write_volatile(value) };
}
