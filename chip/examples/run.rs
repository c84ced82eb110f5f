//! Runs a program for the RP2040 and says what it did: `cargo run --release -p pneudrive-chip
//! --example run -- PROGRAM.elf [MILLISECONDS]`.
//!
//! Bytes that it sends through UART0 go to standard output, everything else to standard error.

use std::error::Error;
use std::io::Write;
use std::time::Instant;
use std::{env, fs, io};

use pneudrive_chip::{Chip, Level, PINS, Ticks};

const UART: usize = 0;
const STEP: Ticks = Ticks::from_millis(1);

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let (path, milliseconds) = match &arguments[..] {
        [path] => (path, 1_000),
        [path, milliseconds] => (path, milliseconds.parse()?),
        _ => return Err("usage: run PROGRAM.elf [MILLISECONDS]".into()),
    };
    let mut chip = Chip::from_elf(&fs::read(path)?)?;
    chip.watch_pins((1 << PINS) - 1);

    let (started, mut edges) = (Instant::now(), [0_u64; PINS]);
    let end = Ticks::from_millis(milliseconds);
    while chip.now() < end {
        chip.run_until((chip.now() + STEP).min(end));
        let sent: Vec<u8> = chip.take_transmitted(UART).map(|character| character.byte).collect();
        io::stdout().write_all(&sent)?;
        for edge in chip.take_pin_edges() {
            edges[usize::from(edge.pin)] += 1;
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    report(&chip, &edges);
    let millions = chip.instructions() as f64 / 1e6;
    eprintln!(
        "{millions:.1} million instructions in {seconds:.2} s, {:.0} million a second",
        millions / seconds
    );
    Ok(())
}

fn report(chip: &Chip, edges: &[u64; PINS]) {
    eprintln!("at {} in {:#010x}, {} cycles", chip.now(), chip.program_counter(), chip.cycles());
    let flash = chip.flash_accesses();
    eprintln!("{} words read from flash, {} of them in the cache", flash.total, flash.hits);
    for reset in chip.resets() {
        eprintln!("reset at {}: {:?}", reset.at, reset.reason);
    }
    for (pin, edges) in edges.iter().enumerate() {
        let level = chip.pin_output(pin);
        if *edges > 0 || level != Level::Floating {
            eprintln!("pin {pin}: {level:?} after {edges} edges");
        }
    }
    if let Some(fault) = chip.last_hard_fault() {
        eprintln!("{} HardFaults, the last one: {fault}", chip.hard_faults());
    }
    for (access, count) in chip.unmodelled_accesses() {
        eprintln!("not emulated: {access}, {count} times");
    }
}
