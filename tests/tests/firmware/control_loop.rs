//! The firmware's control loop and outputs, to the tick.
//!
//! `cargo test -p system-tests --test firmware control_loop:: -- --nocapture` prints the figures
//! that docs/firmware.md states.

use pneudrive_chip::{Level, Ticks};
use system_tests::chip_bench::{BOOT, ChipBench, DIR, PWM, packet};
use system_tests::firmware;

const VENT: [f64; 4] = [-1.0; 4];
const PERIOD: Ticks = Ticks::from_millis(1);

/// A bus in use: the request of this millisecond, and others' frames.
fn traffic(bench: &mut ChipBench, n: u64, commands: [u16; 4]) {
    bench.run(Ticks::from_micros(200 + n * 37 % 150));
    let answer = bench.exchange(packet(0, commands));
    assert!(answer.is_some());
    for other in 1..3 {
        bench.send(&packet(other, [511; 4]).encode());
        bench.run(Ticks::from_micros(115));
    }
}

/// Mean of the intervals between these times and the largest distance of one of them from 1 ms, us.
fn mean_and_jitter_us(times: &[Ticks]) -> (f64, f64) {
    let intervals: Vec<f64> =
        times.windows(2).map(|pair| pair[1].saturating_sub(pair[0]).as_micros()).collect();
    let mean = intervals.iter().sum::<f64>() / intervals.len() as f64;
    let worst = intervals.iter().map(|us| (us - 1_000.0).abs()).fold(0.0, f64::max);
    (mean, worst)
}

/// The log is written in this time, too.
#[test]
fn the_loop_runs_at_1_khz_with_little_jitter_on_a_busy_bus() {
    let mut bench = ChipBench::running(0);
    bench.chip.watch_pins(1 << DIR[0]);
    let start = bench.chip.now();
    let mut samplings = Vec::new();
    // One request a millisecond that turns the valve round: every control step moves the DIR pin.
    for n in 0..1_500_u64 {
        traffic(&mut bench, n, if n % 2 == 0 { [900; 4] } else { [0; 4] });
        bench.chip.run_until(start + PERIOD * (n + 1));
        samplings.push(bench.chip.adc_conversions(0).last_sampled);
    }
    let outputs: Vec<Ticks> = bench.chip.take_pin_edges().into_iter().map(|edge| edge.at).collect();
    assert!(outputs.len() > 1_450, "{} edges", outputs.len());
    // A step may lie on the boundary of two looks at the ADC.
    samplings.dedup();
    for (what, times) in [("samples", samplings), ("outputs", outputs)] {
        let (mean, worst) = mean_and_jitter_us(&times);
        println!("{what} every {mean:.3} us on average; the worst interval is {worst:.1} us off");
        assert!((mean - 1_000.0).abs() < 0.1, "{what}: mean period {mean} us");
        // Which line of the log meets which step depends on every instruction: 22.5 to 24.6 us in
        // five builds that differ in a line.
        assert!(worst < 30.0, "{what}: jitter {worst} us");
    }
}

/// Until the DMA says that it has them all: the ADC goes on until it is told to stop, and what it
/// converts then is thrown away.
#[test]
fn a_step_reads_each_sensor_sixteen_times() {
    const DMA_IRQ_0: usize = 11;
    let mut bench = ChipBench::booted(0);
    let to_the_end_of_the_readings = |bench: &mut ChipBench| {
        let before = bench.chip.interrupts_taken(DMA_IRQ_0);
        bench.run_until_seen(PERIOD * 2, |bench| bench.chip.interrupts_taken(DMA_IRQ_0) > before);
    };
    to_the_end_of_the_readings(&mut bench);
    for step in 0..100 {
        bench.run(PERIOD - Ticks::from_micros(500));
        let count = |bench: &ChipBench| [0, 1, 2, 3].map(|input| bench.chip.adc_conversions(input).count);
        let before = count(&bench);
        to_the_end_of_the_readings(&mut bench);
        let after = count(&bench);
        // The first input's next conversion has begun already.
        assert_eq!([1, 2, 3].map(|input| after[input] - before[input]), [16; 3], "step {step}");
    }
}

/// The voltage changes in the middle of each step's readings: what is answered is their average.
#[test]
fn a_step_averages_its_readings() {
    let (low, high) = (300, 400);
    let mut bench = ChipBench::running(0);
    for readings_low in [4, 8, 12] {
        bench.read([low; 4]);
        // The filter's time constant is 5 steps.
        for _ in 0..60 {
            let before = bench.chip.adc_conversions(0).count;
            bench.run_until_seen(PERIOD * 2, |bench| {
                bench.chip.adc_conversions(0).count == before + readings_low
            });
            bench.read([high; 4]);
            bench.run(Ticks::from_micros(300));
            bench.read([low; 4]);
        }
        let average = low + (high - low) * (16 - readings_low as u16) / 16;
        let values = bench.exchange(packet(0, [102; 4])).map(|answer| answer.packet().values);
        // The channels are read one after the other, and the change falls between two of them.
        for value in values.unwrap_or_default() {
            let off = i32::from(value.get()) - i32::from(average);
            assert!(
                off.abs() <= 7,
                "{readings_low} of 16 readings at {low}: answered {value:?}, not {average}"
            );
        }
    }
}

#[test]
fn the_pwm_runs_at_about_31_khz() {
    let bench = ChipBench::running(0);
    for pin in PWM {
        let period = bench.chip.pwm_period(pin).map_or(0.0, Ticks::as_micros);
        println!("PWM pin {pin}: {:.1} Hz", 1e6 / period);
        assert!((1e6 / period - 31_372.0).abs() < 10.0, "pin {pin}: {period} us");
    }
}

/// Whether all eight valve pins are driven.
fn drives_valves(bench: &ChipBench) -> bool {
    DIR.iter().chain(&PWM).all(|pin| bench.chip.pin_output(*pin) != Level::Floating)
}

/// The pins are driven high from the program's first instructions on, but for the moment in which
/// Embassy resets them; then they float (pulled up on the board). Until the end of the power-up
/// vent none is ever low.
#[test]
fn valve_pins_are_driven_high_from_the_first_instructions_on() {
    let mut bench = ChipBench::power_on(0);
    bench.chip.watch_pins(DIR.into_iter().chain(PWM).fold(0, |pins, pin| pins | 1 << pin));
    let us = Ticks::as_micros;
    let program = bench.run_until_seen(PERIOD, |bench| bench.chip.program_counter() >> 28 == 1);
    let driven = bench.run_until_seen(PERIOD, drives_valves);
    println!("boot loader {:.0} us, then {:.0} us until all valve pins are driven", us(program), us(driven));
    assert!(driven < Ticks::from_micros(150) && program + driven < Ticks::from_micros(250));

    let held = bench.run_until_seen(BOOT, |bench| !drives_valves(bench));
    let let_go = bench.run_until_seen(PERIOD, drives_valves);
    println!("driven for {:.1} ms, then let go for {:.0} us by Embassy", us(held) / 1e3, us(let_go));
    assert!(let_go < Ticks::from_micros(700));
    while bench.chip.now() < BOOT + PERIOD * 1_980 {
        bench.run(Ticks::from_micros(100));
        assert!(drives_valves(&bench), "at {:.0} us", us(bench.chip.now()));
        assert_eq!(bench.coils(), VENT, "at {:.0} us", us(bench.chip.now()));
    }
    assert_eq!(bench.chip.take_pin_edges(), []);
}

#[test]
fn nothing_is_touched_that_the_emulation_does_not_have() {
    let mut bench = ChipBench::running(0);
    assert!(bench.exchange(packet(0, [300; 4])).is_some());
    bench.run(Ticks::from_millis(1_000));
    let accesses: Vec<_> = bench.chip.unmodelled_accesses().collect();
    assert!(accesses.is_empty(), "{accesses:?}");
    assert_eq!(bench.chip.hard_faults(), 0);
    assert_eq!(bench.chip.resets().len(), 1, "{:?}", bench.chip.resets());
}

/// Per cent of its time that the processor works while this is done once a millisecond.
fn load_in_a_second(bench: &mut ChipBench, act: fn(&mut ChipBench, u64)) -> f64 {
    let (cycles, from) = (bench.chip.cycles(), bench.chip.now());
    for n in 0..1_000 {
        let next = bench.chip.now() + PERIOD;
        act(bench, n);
        bench.chip.run_until(next);
    }
    let ticks = bench.chip.now().saturating_sub(from).get();
    100.0 * (bench.chip.cycles() - cycles) as f64 / ticks as f64
}

/// The deepest stack in four seconds with requests, others' frames, sensor faults and logs, and the
/// load with and without a bus.
#[test]
fn the_stack_stays_small_and_the_processor_has_time() {
    let mut bench = ChipBench::running(0);
    let idle = load_in_a_second(&mut bench, |_, _| {});
    let busy = load_in_a_second(&mut bench, |bench, n| traffic(bench, n, [n as u16 % 1024; 4]));
    bench.read([0, 102, 1023, 102]);
    load_in_a_second(&mut bench, |bench, n| traffic(bench, n, [500; 4]));
    println!(
        "processor load {idle:.1} % on a silent bus, {busy:.1} % with one request and two other frames a ms"
    );

    let top = u32::from_le_bytes(std::array::from_fn(|n| {
        bench.chip.read_memory(0x1000_0100 + n as u32).unwrap_or(0)
    }));
    let used = top - bench.chip.lowest_stack_pointer();
    println!("stack: {used} bytes of {} KiB", (top - 0x2000_0000) / 1024);
    assert!(used < 8 * 1024, "{used} bytes of stack");
    println!("ELF: {} bytes to flash", flash_bytes());
}

/// Bytes of all sections that are flashed.
fn flash_bytes() -> u64 {
    let file = elf::ElfBytes::<elf::endian::AnyEndian>::minimal_parse(firmware::elf());
    let segments = file.ok().and_then(|file| file.segments());
    segments.map_or(0, |segments| segments.iter().map(|segment| segment.p_filesz).sum())
}
