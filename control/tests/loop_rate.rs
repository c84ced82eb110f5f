//! The board's loop at 2 kHz: the same closed loop as at 1 kHz, twice as often.

use pneudrive_control::{AdcSample, Board, BoardConfig, Micros, ParameterSet, ValveDrive};
use pneudrive_protocol::pages::Parameter;
use pneudrive_protocol::{Address, CHANNELS, Counts, Packet};
use std::num::NonZeroU16;

const ORIGINAL: BoardConfig = BoardConfig { power_up_vent: Micros::ZERO, ..BoardConfig::ORIGINAL };

/// The table by which a host sets it is what the control crate makes of the original's loop.
#[test]
fn the_parameters_of_a_2_khz_loop_are_those_of_the_same_loop() {
    for (table, config) in [
        (Parameter::LOOP_2_KHZ, BoardConfig::ORIGINAL.at_twice_the_rate()),
        (Parameter::LOOP_1_KHZ, BoardConfig::ORIGINAL),
    ] {
        let mut set = ParameterSet::of(&BoardConfig::ORIGINAL);
        for (parameter, value) in table {
            set.set(parameter, value);
        }
        assert_eq!(set.apply_to(&BoardConfig::ORIGINAL), Ok(config));
    }
    // Two steps weigh as much as one: 232/256 squared is 0.8213, 210/256 is 0.8203.
    let weight = f64::from(BoardConfig::ORIGINAL.at_twice_the_rate().filter_previous) / 256.0;
    assert!((weight * weight - 210.0 / 256.0).abs() < 0.5 / 256.0);
    for previous in 0..=255 {
        let faster = BoardConfig { filter_previous: previous, ..ORIGINAL }.at_twice_the_rate();
        let exact = (f64::from(previous) * 256.0).sqrt();
        assert!((f64::from(faster.filter_previous) - exact).abs() <= 0.5, "{previous}");
    }
}

/// A chamber that fills in proportion to its valve's drive, seen through a converter of 12 bits,
/// averaged as the firmware does.
struct Chamber {
    counts: f64,
    drive: f64,
}

impl Chamber {
    /// Full drive moves it by 3 counts (2.5 kPa) a millisecond.
    const COUNTS_PER_US: f64 = 3e-3;

    fn run(&mut self, us: u64) {
        let rate = self.drive * Self::COUNTS_PER_US;
        self.counts = (self.counts + rate * us as f64).clamp(100.0, 1_000.0);
    }

    fn sample(&self) -> AdcSample {
        AdcSample::from_sum((self.counts * 64.0).round() as u32, NonZeroU16::new(16).unwrap()).unwrap()
    }
}

/// Pressures every millisecond: up, further up, down.
fn response(config: BoardConfig) -> Vec<f64> {
    let mut board = Board::new(config, Address::of_board(0)).unwrap();
    let mut chamber = Chamber { counts: 102.0, drive: -1.0 };
    let period_us = config.loop_period.get();
    let (mut now_us, mut pressures) = (0, Vec::new());
    for command in [400, 430, 250, 245] {
        let values = [Counts::new(command).unwrap(); CHANNELS];
        for step in 0..400_000 / period_us {
            // A host that polls at 100 Hz, so that nobody holds.
            if (step * period_us).is_multiple_of(10_000) {
                for byte in (Packet { address: Address::of_board(0), values }).encode() {
                    board.receive_byte(Micros::new(now_us), byte);
                }
                board.line_idle(Micros::new(now_us));
            }
            let drives = board.control_step(Micros::new(now_us), [chamber.sample(); CHANNELS]);
            chamber.drive = f64::from(drives[0].get()) / f64::from(ValveDrive::FULL);
            chamber.run(period_us);
            now_us += period_us;
            if now_us.is_multiple_of(1_000) {
                pressures.push(chamber.counts);
            }
        }
    }
    pressures
}

fn largest_difference(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

/// Measured: 0.09 counts, of the filter's weight, which is rounded to 1/256, and of valves that
/// follow half a millisecond earlier.
#[test]
fn the_closed_loop_is_the_same_at_2_khz() {
    let usual = response(ORIGINAL);
    let faster = response(ORIGINAL.at_twice_the_rate());
    let largest = largest_difference(&usual, &faster);
    println!("largest difference in 1.6 s of steps: {largest:.2} counts");
    assert!(largest < 0.2, "{largest} counts");
    // Without the change of what counts steps it is another loop.
    let naive = BoardConfig { loop_period: Micros::new(500), ..ORIGINAL };
    let wrong = largest_difference(&usual, &response(naive));
    println!("with the period alone changed: {wrong:.2} counts");
    assert!(wrong > 2.0, "{wrong} counts");
}

#[test]
fn a_sensor_fault_takes_as_long_as_before() {
    for config in [ORIGINAL, ORIGINAL.at_twice_the_rate()] {
        let mut board = Board::new(config, Address::of_board(0)).unwrap();
        let period_us = config.loop_period.get();
        let good = [AdcSample::from(Counts::ATMOSPHERE); CHANNELS];
        let mut now_us = 0;
        let mut step = |samples| {
            now_us += period_us;
            board.control_step(Micros::new(now_us), samples);
            (now_us, board.status().counters.sensor_faults)
        };
        let (began_us, _) = step(good);
        let found_us = loop {
            let (now_us, faults) = step([AdcSample::from_reading(0); CHANNELS]);
            if faults > 0 {
                break now_us - began_us;
            }
        };
        assert_eq!(found_us, 10_000, "with a period of {period_us} us");
    }
}
