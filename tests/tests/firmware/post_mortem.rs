//! What a board knows after a reset about the run before it.

use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{PostMortem, StopCause};
use pneudrive_protocol::{CheckedPacket, Direction, Sequence};
use system_tests::chip_bench::{BOOT, ChipBench, packet};
use system_tests::firmware;

const MS: Ticks = Ticks::from_millis(1);
/// Branches to itself.
const HANG: u16 = 0xE7FE;
/// Permanently undefined: a HardFault.
const UNDEFINED: u16 = 0xDE00;
/// Returns at once.
const RETURN: u16 = 0x4770;
const TIMER_IRQ_0: usize = 0;
const DMA_IRQ_1: usize = 12;

/// The record of the run before, as a debugger reads it.
fn last(bench: &ChipBench) -> Option<PostMortem> {
    let address = firmware::address_of_variable("LAST_POST_MORTEM");
    let byte = |offset| bench.chip.read_memory(address + offset).unwrap_or(0);
    let word = |n| u32::from_le_bytes(std::array::from_fn(|k| byte(4 * n as u32 + k as u32)));
    PostMortem::from_words(&std::array::from_fn(word))
}

/// Runs on until the boot after the next reset (131 ms, most of it the copy of the program to RAM),
/// and gives the record with the time of that reset.
fn after_reset(bench: &mut ChipBench) -> (PostMortem, Ticks) {
    let resets = bench.chip.resets().len();
    bench.run_until_seen(MS * 400, |bench| bench.chip.resets().len() > resets);
    let at = bench.chip.resets()[resets].at;
    bench.run(MS * 150);
    (last(bench).unwrap_or_else(|| panic!("nothing is known")), at)
}

/// A board that is well until it is sent a checked request.
fn running_with(instruction: u16) -> ChipBench {
    let mut bench = ChipBench::power_on_with(&firmware::with_broken("CheckedPacket5parse", instruction), 0);
    bench.run(BOOT + MS * 100);
    let request = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(1) };
    let end = bench.send(&request.encode(Direction::Request));
    bench.chip.run_until(end);
    bench
}

#[test]
fn a_hard_fault_is_known_with_its_registers() {
    let mut bench = running_with(UNDEFINED);
    let faulted = bench.chip.now();
    let (record, _) = after_reset(&mut bench);
    let StopCause::HardFault(registers) = record.cause else { panic!("{record:?}") };
    assert_eq!(registers.pc, firmware::address_of_function("CheckedPacket5parse"));
    assert_eq!(registers.xpsr & 0x3f, 16 + DMA_IRQ_1 as u32, "in the bus's interrupt");
    assert_eq!(registers.lr & 1, 1);
    // The board's clock starts with Embassy, 128 ms after the chip's.
    let boot = faulted.as_micros() - record.at_us as f64;
    assert!((128_000.0..132_000.0).contains(&boot), "{record:?}");
}

#[test]
fn a_panic_is_known_with_its_place() {
    // Started a second time, `main` cannot spawn its task.
    let main = (TIMER_IRQ_0, "main", "src/main.rs");
    let acquire = (DMA_IRQ_1, "_critical_section_1_0_acquire", "src/masking.rs");
    for (irq, function, file) in [main, acquire] {
        let mut bench = ChipBench::power_on_with(&firmware::with_handler(irq, function), 0);
        let (record, _) = after_reset(&mut bench);
        let StopCause::Panic { file: found, line } = record.cause else { panic!("{function}: {record:?}") };
        assert!(found.as_str().ends_with(file), "{function}: {record:?}");
        assert!(line > 10, "{function}: {record:?}");
    }
}

#[test]
fn the_part_that_kept_the_watchdog_from_being_fed_is_known() {
    for (function, control_ran, bus_ran) in [("SWI_IRQ_0", false, true), ("DMA_IRQ_1", true, false)] {
        let mut bench = ChipBench::power_on_with(&firmware::with_broken(function, RETURN), 0);
        let (record, reset) = after_reset(&mut bench);
        assert_eq!(record.cause, StopCause::LastCheck { control_ran, bus_ran }, "{function}");
        assert!(reset.as_micros() > record.at_us as f64);
    }
}

/// The bus interrupt hangs, so the check is not made any more: its last one, when all was well,
/// tells when.
#[test]
fn a_check_that_is_not_made_any_more_is_known() {
    let mut bench = running_with(HANG);
    let hung_ms = bench.chip.now().as_micros() / 1e3;
    let (record, _) = after_reset(&mut bench);
    assert_eq!(record.cause, StopCause::LastCheck { control_ran: true, bus_ran: true });
    let last_check_ms = record.at_us as f64 / 1e3 + 130.0;
    assert!((hung_ms - 13.0..hung_ms + 3.0).contains(&last_check_ms), "{hung_ms} {record:?}");
}

/// Only of the run before, and only after the watchdog.
#[test]
fn nothing_is_known_after_power_on() {
    let mut bench = running_with(UNDEFINED);
    after_reset(&mut bench);
    bench.chip.power_cycle();
    bench.run(BOOT);
    assert_eq!(last(&bench), None);
    assert_eq!(last(&ChipBench::booted(0)), None);
}

/// It is logged: the log of such a start is longer.
#[test]
fn the_log_says_it() {
    let mut plain = ChipBench::power_on(0);
    plain.run(BOOT);
    let plain = plain.chip.take_rtt().len();
    let mut bench = running_with(UNDEFINED);
    let _ = bench.chip.take_rtt();
    after_reset(&mut bench);
    bench.run(BOOT);
    let log = bench.chip.take_rtt().len();
    // Nine registers and a time; zero bytes in them take no room in the log.
    assert!(log > plain + 20, "{log} bytes of log, {plain} after power-on");
}
