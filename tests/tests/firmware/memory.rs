//! Where the firmware's code lies, and how long it answers with a cold cache: a word of flash that
//! the cache does not have costs 0.4 us.
//!
//! `cargo test -p system-tests --test firmware memory:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

use std::collections::BTreeSet;

use pneudrive_chip::Ticks;
use pneudrive_protocol::{CheckedPacket, Direction, Sequence};
use system_tests::chip_bench::{BOOT, ChipBench, FILL, packet};
use system_tests::firmware;

const LATEST: Ticks = Ticks::from_micros(20);
const US: Ticks = Ticks::from_micros(1);
const MS: Ticks = Ticks::from_millis(1);

/// How long the board takes to answer, us.
fn answer_us(bench: &mut ChipBench, n: u16) -> f64 {
    let answer =
        bench.exchange(packet(0, [n % 1024; 4])).unwrap_or_else(|| panic!("request {n} was not answered"));
    assert!(answer.delay >= US * 13, "request {n}: {} us", answer.delay.as_micros());
    answer.delay.as_micros()
}

fn assert_in_time(what: &str, mut delays_us: Vec<f64>) {
    delays_us.sort_by(f64::total_cmp);
    let (least, most) = (delays_us[0], delays_us[delays_us.len() - 1]);
    println!("{what}: answers after {least:.1} to {most:.1} us, {} tries", delays_us.len());
    assert!(most <= LATEST.as_micros(), "{what}: {most} us");
}

#[test]
fn the_first_answer_after_a_reset_is_in_time() {
    let mut bench = ChipBench::booted(0);
    assert_in_time("first after a reset", vec![answer_us(&mut bench, 102)]);
}

#[test]
fn an_answer_after_a_minute_of_silence_is_in_time() {
    let mut bench = ChipBench::running(0);
    answer_us(&mut bench, 102);
    bench.run(MS * 60_000);
    assert_in_time("after a minute without a host", vec![answer_us(&mut bench, 102)]);
}

/// The log is written once a second, and takes as much of the cache as it needs.
#[test]
fn answers_while_and_after_the_log_is_written_are_in_time() {
    let mut bench = ChipBench::running(0);
    let _ = bench.chip.take_rtt();
    let mut before = bench.clone();
    while bench.chip.take_rtt().is_empty() {
        before = bench.clone();
        bench.run(US * 100);
    }
    let delays = (0..300).map(|n| {
        let mut bench = before.clone();
        bench.run(US * (n * 5));
        answer_us(&mut bench, 102)
    });
    assert_in_time("while the log is written and after it", delays.collect());
}

/// The worst that other code can do to the cache.
#[test]
fn answers_with_an_empty_cache_are_in_time() {
    let mut bench = ChipBench::running(0);
    let delays = (0..1_000).map(|n| {
        bench.run(Ticks::new(u64::from(n) * 7_919 % 125_000));
        bench.chip.flush_xip_cache();
        answer_us(&mut bench, n)
    });
    assert_in_time("with an empty cache", delays.collect());
}

/// What may be in flash: the boot stage, which copies the rest, and what vents the valves when RAM
/// is not to be trusted.
const IN_FLASH: [&str; 11] = [
    "Reset",
    "__wrap___pre_init",
    "choose_program",
    "boot_hard_fault",
    "boot12run_recorded",
    "boot3run17h",
    "boot9is_record",
    "boot4load",
    "boot10is_program",
    "boot4copy",
    "boot8checksum",
];

fn is_ram(address: u32) -> bool {
    (0x2000_0000..0x2004_0000).contains(&address)
}

#[test]
fn every_function_but_start_up_and_fault_handler_is_in_ram() {
    let (in_ram, in_flash): (Vec<_>, Vec<_>) =
        firmware::functions().into_iter().partition(|(_, address)| is_ram(*address));
    // Calls between flash and RAM go through short pieces of code that the linker adds.
    let others: Vec<_> = in_flash
        .iter()
        .filter(|(name, _)| !name.contains("Thunk") && !IN_FLASH.iter().any(|allowed| name.contains(allowed)))
        .collect();
    assert!(others.is_empty(), "{others:?}");
    assert!(in_ram.len() > 100, "{} functions in RAM", in_ram.len());
}

/// The addresses of all instructions until `end`, one by one.
fn executed(bench: &mut ChipBench, end: Ticks) -> BTreeSet<u32> {
    let mut addresses = BTreeSet::new();
    while bench.chip.now() < end {
        if !bench.chip.is_asleep() {
            addresses.insert(bench.chip.program_counter());
        }
        bench.run(Ticks::new(1));
    }
    addresses
}

/// The functions that these addresses are in.
fn names(addresses: &BTreeSet<u32>) -> BTreeSet<String> {
    let mut functions = firmware::functions();
    functions.sort_by_key(|(_, address)| *address);
    let function = |address: &u32| {
        let after = functions.partition_point(|(_, start)| start <= address);
        functions[after.checked_sub(1).expect("an address of the program")].0.clone()
    };
    addresses.iter().map(function).collect()
}

/// Traced from the request's first byte to the end of the answer, which is done by interrupts, over
/// a whole control step.
#[test]
fn nothing_between_a_request_and_its_answer_comes_from_flash() {
    let mut bench = ChipBench::running(0);
    bench.chip.flush_xip_cache();
    let before = bench.chip.flash_accesses();
    let end = bench.send(&packet(0, [300; 4]).encode());
    let addresses = executed(&mut bench, end + MS);
    assert_eq!(bench.chip.take_transmitted(0).count(), 10);
    let elsewhere: Vec<_> = addresses.iter().filter(|address| !is_ram(**address)).collect();
    assert!(elsewhere.is_empty(), "{elsewhere:x?}");
    let names = names(&addresses);
    println!("{} instructions in {} functions were executed", addresses.len(), names.len());
    for path in ["DMA_IRQ_1", "TIMER_IRQ_1", "SWI_IRQ_0", "TIMER_IRQ_0", "ControlLoop4step"] {
        assert!(names.iter().any(|name| name.contains(path)), "{path} is not among {names:?}");
    }
    assert_eq!(bench.chip.flash_accesses(), before, "constants and vectors neither");
}

/// With log, control loop, requests, and a host that goes away.
#[test]
fn flash_is_not_read_any_more_after_the_start() {
    let mut bench = ChipBench::booted(0);
    let before = bench.chip.flash_accesses();
    for _ in 0..1_500 {
        assert!(bench.exchange(packet(0, [300; 4])).is_some());
        bench.run(MS);
    }
    bench.run(MS * 3_000);
    assert_eq!(bench.chip.flash_accesses(), before);
}

/// So that a stray write to RAM cannot keep the valves from being vented: before the first
/// instruction of the handler from RAM.
#[test]
fn a_hard_fault_vents_from_flash() {
    /// Permanently undefined.
    const UNDEFINED: u16 = 0xDE00;
    let mut bench = ChipBench::power_on_with(&firmware::with_broken("CheckedPacket5parse", UNDEFINED), 0);
    bench.run(BOOT + MS * 2_000);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 5);
    let request = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(1) };
    bench.send(&request.encode(Direction::Request));
    bench.run_until_seen(MS, |bench| bench.chip.hard_faults() == 1);
    assert_eq!(bench.coils(), FILL);
    let start = bench.chip.now();
    while !is_ram(bench.chip.program_counter()) {
        assert!(bench.chip.now() - start < US * 50);
        bench.run(Ticks::new(1));
    }
    println!("a HardFault has vented after {:.1} us", (bench.chip.now() - start).as_micros());
    assert!(bench.chip.now() > start, "it begins in flash");
    assert!(bench.drives_vent());
}
