//! How long the firmware takes to reach a safe state, and how it starts: the figures of
//! docs/reliability.md.
//!
//! `cargo test -p system-tests --test firmware reaction:: -- --nocapture` prints them.

use pneudrive_chip::{Level, Ticks};
use pneudrive_protocol::{CheckedPacket, Direction, Sequence};
use system_tests::chip_bench::{ChipBench, DIR, PWM, packet};

const VENT: [f64; 4] = [-1.0; 4];
const FILL: [f64; 4] = [1.0; 4];
const MS: Ticks = Ticks::from_millis(1);

/// Fills all four chambers; the request has just ended, `phase` after some point in the control
/// loop.
fn filling(running: &ChipBench, phase: Ticks) -> ChipBench {
    let mut bench = running.clone();
    bench.run(phase);
    assert!(bench.exchange(packet(0, [500; 4])).is_some());
    bench.run(MS * 3);
    assert_eq!(bench.coils(), FILL);
    bench.run(phase);
    let end = bench.send(&packet(0, [500; 4]).encode());
    bench.chip.run_until(end);
    bench
}

/// Whether a valve does something else than vent.
fn stirs(bench: &ChipBench) -> bool {
    bench.coils().iter().any(|coil| *coil > -1.0)
}

fn report(what: &str, times: &[Ticks]) -> (f64, f64) {
    let ms = |time: Option<&Ticks>| time.map_or(0.0, |time| time.as_micros() / 1e3);
    let (least, most) = (ms(times.iter().min()), ms(times.iter().max()));
    println!("{what}: {least:.2} to {most:.2} ms, {} tries", times.len());
    (least, most)
}

#[test]
fn from_the_last_request_to_vented_valves() {
    let running = ChipBench::running(0);
    let times: Vec<Ticks> = (0..8)
        .map(|n| {
            let mut bench = filling(&running, Ticks::from_micros(n * 130));
            bench.run(MS * 2_499);
            assert_eq!(bench.coils(), FILL, "it holds until then");
            MS * 2_499 + bench.run_until_seen(MS * 10, ChipBench::drives_vent)
        })
        .collect();
    let (least, most) = report("host dead: from its last stop bit to all valve pins high", &times);
    assert!(least >= 2_500.0 && most <= 2_501.5, "500 ms, 2 s, and a control step");
}

/// A host that polls the other boards, and has the wrong number for this one, is no host to it.
#[test]
fn frames_for_other_boards_do_not_keep_it_from_venting() {
    let mut bench = filling(&ChipBench::running(0), MS);
    let start = bench.chip.now();
    for n in 0..2_499 {
        for board in 1..4 {
            bench.send(&packet(board, [500; 4]).encode());
            bench.run(Ticks::from_micros(114));
            bench.send(&packet(board, [n % 1024; 4]).encode());
            bench.run(Ticks::from_micros(100));
        }
        bench.chip.run_until(start + MS * (u64::from(n) + 1));
    }
    assert_eq!(bench.coils(), FILL);
    let time = MS * 2_499 + bench.run_until_seen(MS * 10, ChipBench::drives_vent);
    let (_, most) = report("host talks to the wrong board: from its last request to this one", &[time]);
    assert!(most <= 2_501.5);
}

#[test]
fn from_a_broken_sensor_to_a_vented_valve() {
    let running = ChipBench::running(0);
    let mut times = Vec::new();
    for (n, code) in (0..20).flat_map(|n| [(n, 0), (n, 4_095)]) {
        let mut bench = filling(&running, Ticks::from_micros(n * 53));
        bench.chip.set_adc(2, code);
        let (dir, pwm) = (DIR[2], PWM[2]);
        let vents = |bench: &ChipBench| {
            bench.chip.pin_output(dir) == Level::High && bench.chip.pwm_duty(pwm) == Some(1.0)
        };
        let mut time = bench.run_until_seen(MS * 20, vents);
        // A sensor that breaks within a step's readings has, on their average, just a high
        // pressure: that step vents, the next one does not.
        let mut next_step = bench.clone();
        next_step.run(MS);
        if !vents(&next_step) {
            time += MS + next_step.run_until_seen(MS * 20, vents);
            bench = next_step;
        }
        times.push(time);
        assert_eq!(bench.coils(), [1.0, 1.0, -1.0, 1.0], "the others go on");
    }
    let (least, most) = report("sensor broken: to both pins of its valve high", &times);
    assert!(least > 8.9 && most < 10.3, "ten samples in a row");
}

/// A host whose loop has hung and repeats its last request, number and all, is obeyed:
/// docs/reliability.md says so.
#[test]
fn a_host_that_repeats_itself_is_obeyed() {
    let mut bench = ChipBench::running(0);
    let stuck = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(7) };
    let stuck = stuck.encode(Direction::Request);
    for _ in 0..600 {
        assert!(bench.exchange_bytes(&stuck).is_some());
        bench.run(MS * 10);
    }
    assert_eq!(bench.coils(), FILL, "after 6 s");
}

/// Asked every millisecond from power-on: when it first answers, and when a valve first does
/// something else than vent.
#[test]
fn power_up() {
    let mut bench = ChipBench::power_on(0);
    let (mut driven, mut answered, mut obeyed) = (None, None, None);
    while obeyed.is_none() {
        assert!(bench.chip.now() < MS * 3_000);
        let now = bench.chip.now();
        let says = bench.exchange(packet(0, [500; 4])).is_some();
        if driven.is_none() && DIR.iter().chain(&PWM).all(|pin| bench.chip.pin_output(*pin) == Level::High) {
            driven = Some(now);
        }
        answered = answered.or(says.then_some(now));
        obeyed = obeyed.or(stirs(&bench).then_some(now));
        bench.chip.run_until(now + MS);
    }
    let ms = |time: Option<Ticks>| time.map_or(f64::NAN, |time| time.as_micros() / 1e3);
    let (driven, answered, obeyed) = (ms(driven), ms(answered), ms(obeyed));
    println!(
        "power-up: pins driven (vent) at {driven:.0} ms, first answer at {answered:.0} ms, first command obeyed at {obeyed:.0} ms"
    );
    assert!(driven <= answered && answered < 135.0 && (2_129.0..2_136.0).contains(&obeyed));
}

/// The supply of the chip fails and comes back while it fills, for all phases of its loop: the
/// pull-ups vent from the first tick on, and no pin is low before the next power-up vent is over.
#[test]
fn brown_out() {
    let running = ChipBench::running(0);
    let valve_pins = DIR.into_iter().chain(PWM).fold(0, |pins, pin| pins | 1 << pin);
    let mut times = Vec::new();
    for n in 0..4 {
        let mut bench = filling(&running, Ticks::from_micros(n * 237));
        bench.chip.power_cycle();
        let start = bench.chip.now();
        assert_eq!(bench.coils(), VENT, "from the first tick on");
        bench.chip.watch_pins(valve_pins);
        bench.run(MS * 2_000);
        assert!(bench.exchange(packet(0, [500; 4])).is_some());
        assert_eq!(bench.chip.take_pin_edges(), [], "no valve pin moves for two seconds");
        bench.chip.watch_pins(0);
        bench.run_until_seen(MS * 200, stirs);
        times.push(bench.chip.now().saturating_sub(start));
    }
    let (least, _) =
        report("after a brown-out: to the first valve that does something else than vent", &times);
    assert!(least > 2_100.0);
}
