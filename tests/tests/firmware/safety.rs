//! The firmware when things go wrong: no host, no sensor, no program.

use pneudrive_chip::{Level, ResetReason, Ticks};
use pneudrive_protocol::{CheckedPacket, Counts, Direction, Sequence};
use system_tests::chip_bench::{BOOT, ChipBench, DIR, FILL, LED, PWM, VENT, packet};
use system_tests::firmware;

const MS: Ticks = Ticks::from_millis(1);

/// Branches to itself.
const HANG: u16 = 0xE7FE;
/// Permanently undefined: a HardFault.
const UNDEFINED: u16 = 0xDE00;

#[test]
fn it_holds_for_two_seconds_when_the_host_dies_and_then_vents() {
    let mut bench = ChipBench::filling();
    // The request was answered 5 ms ago; 500 ms of patience and 2 s of hold.
    bench.run(MS * 2_490);
    assert_eq!(bench.coils(), FILL);
    bench.run(MS * 10);
    assert_eq!(bench.coils(), VENT);
    bench.run(MS * 1_000);
    assert_eq!(bench.coils(), VENT);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 2);
    assert_eq!(bench.coils(), FILL, "a request revives it");
}

/// The original's client is obeyed as soon as a host that checks has left.
#[test]
fn it_forgets_a_host_that_leaves_at_once() {
    let mut bench = ChipBench::running(0);
    let checked =
        |packet, number| CheckedPacket { packet, sequence: Sequence::new(number) }.encode(Direction::Request);
    assert!(bench.exchange_bytes(&checked(packet(0, [500; 4]), 1)).is_some());
    bench.run(MS * 5);
    assert_eq!(bench.coils(), FILL);
    assert!(bench.exchange(packet(0, [700; 4])).is_none(), "an unchecked client beside a host that checks");
    let leave = CheckedPacket::leave(packet(0, [0; 4]).address, Sequence::new(2));
    let answer = bench.exchange_bytes(&leave.encode(Direction::Request)).map(|answer| answer.bytes());
    let answer = answer.and_then(|bytes| CheckedPacket::decode(&bytes, Direction::Answer).ok());
    assert_eq!(answer.map(|answer| answer.sequence.get()), Some(2));
    bench.run(MS * 2);
    assert_eq!(bench.coils(), VENT);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 2);
    assert_eq!(bench.coils(), FILL, "the unchecked client is obeyed");
}

#[test]
fn a_broken_sensor_vents_its_chamber_and_the_answer_says_so() {
    let mut bench = ChipBench::filling();
    bench.read([102, 0, 1023, 102]);
    bench.run(MS * 12);
    assert_eq!(bench.coils(), [1.0, -1.0, -1.0, 1.0]);
    let values = bench.exchange(packet(0, [500; 4])).map(|answer| answer.packet().values);
    assert_eq!(values, Some([102, 0, 1023, 102].map(Counts::saturating)));
    bench.read([102; 4]);
    for _ in 0..4 {
        assert!(bench.exchange(packet(0, [500; 4])).is_some());
        bench.run(MS * 245);
    }
    assert_eq!(bench.coils(), [1.0, -1.0, -1.0, 1.0], "not for a second");
    bench.run(MS * 40);
    assert_eq!(bench.coils(), FILL);
}

#[test]
fn partial_drives_reach_the_pins() {
    let mut bench = ChipBench::running(0);
    bench.read([300; 4]);
    bench.run(MS * 100);
    // 20, -20, 8 and 0 counts of error: drives of 200, -200, 80 and 0 of 400.
    assert!(bench.exchange(packet(0, [320, 280, 308, 300])).is_some());
    bench.run(MS * 5);
    let expected = [127.0 / 255.0, -127.0 / 255.0, 51.0 / 255.0, 0.0];
    for (coil, expected) in bench.coils().into_iter().zip(expected) {
        // The PWM has 3984 steps.
        assert!((coil - expected).abs() < 1.0 / 3984.0, "{coil} instead of {expected}");
    }
}

#[test]
fn the_led_tells_running_from_waiting() {
    let mut bench = ChipBench::filling();
    bench.chip.watch_pins(1 << LED);
    bench.run(MS * 400);
    assert_eq!(bench.chip.take_pin_edges(), []);
    assert_eq!(bench.chip.pin_level(LED), Level::High);
    bench.run(MS * 3_000);
    assert!(bench.chip.take_pin_edges().len() >= 4, "it blinks when the host is gone");
}

/// Returns at once, as if there were nothing to do.
const RETURN: u16 = 0x4770;

/// A fault in the middle of a run: the function is first used by a checked request, and the valves
/// fill until then.
#[test]
fn a_hard_fault_while_filling_vents_at_once_and_not_at_the_reset() {
    let mut bench = ChipBench::power_on_with(&firmware::with_broken("CheckedPacket5parse", UNDEFINED), 0);
    bench.run(BOOT + MS * 2_000);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 5);
    assert_eq!(bench.coils(), FILL);
    let request = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(1) };
    let request_end = bench.send(&request.encode(Direction::Request));
    bench.chip.run_until(request_end);
    let vented = bench.run_until_seen(MS, ChipBench::drives_vent);
    println!("from the faulty instruction's request to all valve pins high: {:.1} us", vented.as_micros());
    assert!(vented < Ticks::from_micros(100), "{} us", vented.as_micros());
    assert_eq!((bench.chip.hard_faults(), bench.chip.resets().len()), (1, 1), "not by a reset");
    bench.run(MS * 60);
    assert_eq!(bench.chip.resets().len(), 2, "and then the watchdog resets it");
    assert_eq!(bench.coils(), VENT);
}

/// A control loop that does not hang but is simply no longer called: interrupts and the thread go
/// on, and only its missing report keeps the watchdog from being fed.
#[test]
fn the_watchdog_resets_a_control_loop_that_stops() {
    is_reset_and_vents("SWI_IRQ_0", RETURN);
}

/// The same for the bus.
#[test]
fn the_watchdog_resets_a_bus_interrupt_that_stops() {
    is_reset_and_vents("DMA_IRQ_1", RETURN);
}

/// The bus's interrupts are not masked in critical sections, so they must not take any. If one
/// does, the board stops before anything is shared: without the check it would go on until the
/// watchdog's time is over.
#[test]
fn a_critical_section_in_a_bus_interrupt_stops_the_board() {
    const DMA_IRQ_1: usize = 12;
    const TIMER_IRQ_1: usize = 1;
    for irq in [DMA_IRQ_1, TIMER_IRQ_1] {
        let broken = firmware::with_handler(irq, "_critical_section_1_0_acquire");
        let mut bench = ChipBench::power_on_with(&broken, 0);
        bench.run(BOOT);
        let resets = bench.chip.resets().len();
        let _ = bench.exchange(packet(0, [500; 4]));
        let taken = bench.chip.interrupts_taken(irq);
        assert!(taken > 0);
        bench.run(MS * 20);
        assert_eq!(bench.chip.interrupts_taken(irq), taken, "interrupt {irq} is not handled again");
        bench.run(MS * 60);
        assert!(bench.chip.resets().len() > resets);
        assert_eq!(bench.coils(), VENT);
    }
}

/// A program that hangs or faults in this function: the watchdog resets the chip again and again,
/// and no valve pin is ever low.
fn is_reset_and_vents(function: &str, instruction: u16) {
    let mut bench = ChipBench::power_on_with(&firmware::with_broken(function, instruction), 0);
    bench.chip.watch_pins(DIR.into_iter().chain(PWM).fold(0, |pins, pin| pins | 1 << pin));
    bench.run(MS * 600);
    let resets = bench.chip.resets().to_vec();
    assert!(resets.len() >= 3, "{function}: {resets:?}");
    for pair in resets.windows(2) {
        assert_eq!(pair[1].reason, ResetReason::WatchdogTimer);
        // 128 ms of boot and 50 ms of patience.
        let lived = pair[1].at.saturating_sub(pair[0].at);
        assert!(lived < MS * 200, "{function}: lived for {} us", lived.as_micros());
    }
    assert_eq!(bench.coils(), VENT);
    assert_eq!(bench.chip.take_pin_edges(), []);
}

#[test]
fn the_watchdog_resets_a_control_loop_that_hangs() {
    is_reset_and_vents("ControlLoop4step", HANG);
}

#[test]
fn the_watchdog_resets_a_bus_interrupt_that_hangs() {
    is_reset_and_vents("DMA_IRQ_1", HANG);
}

#[test]
fn a_hard_fault_vents_and_resets() {
    is_reset_and_vents("ControlLoop4step", UNDEFINED);
}
