//! The firmware when the chip itself does not do its part: a converter that fails, a DMA channel
//! that stops, a processor that stands still at the wrong moment.

use pneudrive_chip::{Level, ResetReason, Ticks};
use system_tests::chip_bench::{BUS, ChipBench, DRIVER_ENABLE, FILL, VENT, packet};

const MS: Ticks = Ticks::from_millis(1);
const US: Ticks = Ticks::from_micros(1);

/// DMA channel that takes the bus's characters from the UART (firmware/src/bus/receiver.rs).
const CHARACTERS_CHANNEL: usize = 0;

/// Within the watchdog's 50 ms and one of its checks, 10 ms.
#[track_caller]
fn is_reset_soon(bench: &mut ChipBench, what: &str) {
    let from = bench.chip.now();
    bench.run(MS * 61);
    let resets = bench.chip.resets();
    assert_eq!((resets.len(), resets[1].reason), (2, ResetReason::WatchdogTimer), "{what}");
    println!("{what}: reset after {:.1} ms", resets[1].at.saturating_sub(from).as_micros() / 1e3);
    assert_eq!(bench.coils(), VENT);
}

/// Without samples there is no control step, and the valves stay as they are: only the reset vents
/// them.
#[test]
fn a_converter_that_fails_is_a_reset() {
    let mut bench = ChipBench::filling();
    (0..4).for_each(|channel| bench.chip.set_adc(channel, 408));
    bench.chip.set_adc_failing(true);
    is_reset_soon(&mut bench, "ADC fails");
    // As long as it lasts.
    bench.run(MS * 600);
    assert!(bench.chip.resets().len() >= 4);
    assert_eq!(bench.coils(), VENT);
    bench.chip.set_adc_failing(false);
    bench.run(MS * 2_400);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 2);
    assert_eq!(bench.coils(), FILL, "and not longer");
}

/// One conversion that fails costs a step, not a reset.
#[test]
fn a_conversion_that_fails_now_and_then_is_none() {
    let mut bench = ChipBench::filling();
    for n in 0..100 {
        bench.chip.set_adc_failing(true);
        bench.run(Ticks::from_micros(1_100));
        bench.chip.set_adc_failing(false);
        bench.run(MS * 3);
        assert!(bench.exchange(packet(0, [500; 4])).is_some(), "exchange {n}");
        assert_eq!(bench.coils(), FILL, "{n}");
    }
    assert_eq!(bench.chip.resets().len(), 1);
}

/// The bus interrupt goes on, because supervision asks for it: that it hears nothing any more must
/// show.
#[test]
fn a_receiver_that_stops_is_a_reset() {
    let mut bench = ChipBench::filling();
    bench.chip.abort_dma(CHARACTERS_CHANNEL);
    is_reset_soon(&mut bench, "receiver's DMA channel stops");
    bench.run(MS * 140);
    assert!(bench.exchange(packet(0, [102; 4])).is_some(), "and it hears again");
}

/// The processor stands still from before the request's last byte until long after the answer's
/// time: it is late, but it comes, and the next one is on time.
#[test]
fn an_answer_whose_time_has_passed_is_sent_at_once() {
    let mut start = ChipBench::running(0);
    start.run(US * 333);
    for stall_us in [13, 14, 15, 16, 20, 40, 80] {
        let mut bench = start.clone();
        let end = bench.send(&packet(0, [300; 4]).encode());
        bench.chip.run_until(end.saturating_sub(US));
        let _ = bench.chip.take_transmitted(BUS).count();
        bench.chip.stall_until(end + US * stall_us);
        bench.chip.run_until(end + US * (stall_us + 120));
        let characters: Vec<_> = bench.chip.take_transmitted(BUS).collect();
        assert_eq!(characters.len(), 10, "stalled for {stall_us} us after the request");
        let late = characters[0].start.saturating_sub(end + US * stall_us);
        assert!(late < US * 20, "{} us after the processor went on", late.as_micros());
        assert!(bench.exchange(packet(0, [300; 4])).is_some());
    }
}

/// Wherever the processor stands still for a moment: the driver is enabled from before the answer's
/// first start bit to after its last stop bit.
#[test]
fn the_driver_stays_enabled_for_a_late_answer() {
    let mut start = ChipBench::running(0);
    start.chip.watch_pins(1 << DRIVER_ENABLE);
    start.run(US * 333);
    let end = start.send(&packet(0, [300; 4]).encode());
    start.chip.run_until(end);
    let _ = start.chip.take_transmitted(BUS).count();
    for stall_us in [1, 3, 9] {
        // From the request's end over the alarm that starts the answer to the one that ends it;
        // steps of 80 ns.
        for n in 0..1_500 {
            let mut bench = start.clone();
            let from = end + Ticks::new(10 * n);
            bench.chip.run_until(from);
            bench.chip.stall_until(from + US * stall_us);
            bench.chip.run_until(end + US * 180);
            let characters: Vec<_> = bench.chip.take_transmitted(BUS).collect();
            assert_eq!(characters.len(), 10);
            let edges = bench.chip.take_pin_edges();
            let [on, off] = edges[..] else { panic!("{edges:?}") };
            let context =
                format!("stalled for {stall_us} us, {} us after the request", (from - end).as_micros());
            assert_eq!((on.level, off.level), (Level::High, Level::Low));
            assert!(on.at <= characters[0].start, "{context}: enabled too late");
            assert!(off.at >= characters[9].end, "{context}: disabled too early");
        }
    }
}
