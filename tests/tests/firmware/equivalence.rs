//! The native board and the chip do the same: one story, told to both.
//!
//! The story is a script of milliseconds. Half a millisecond after a control step the sensors
//! change and something is said on the bus; before the next step it is noted what the board has
//! answered and what its valves do. The chip is only watched from outside, at its pins; the native
//! board is the control crate, called as `sim-hil` calls it.

use pneudrive_chip::{LineErrors, Ticks};
use pneudrive_control::{AdcSample, Board, BoardConfig, DirPwm, Micros};
use pneudrive_protocol::{Address, CheckedPacket, Direction, Sequence};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use system_tests::chip_bench::{BUS, CHARACTER, ChipBench, packet};

const OWN: u8 = 1;
/// When in a millisecond the sensors change and the bus is used, and when it is noted what came of
/// it, us after the step.
const ACT_US: u64 = 400;
const NOTE_US: u64 = 950;

/// Something on the bus: bytes, each this long after the one before it has ended.
type Speech = Vec<Said>;

#[derive(Debug, Clone, Copy)]
struct Said {
    pause_us: u64,
    byte: u8,
    damaged: bool,
}

struct Millisecond {
    /// 12-bit ADC codes.
    codes: [u16; 4],
    speech: Speech,
}

/// What was seen of a board in a millisecond.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    answers: Vec<u8>,
    /// Duty of the PWM pins in timer steps, and level of the DIR pins.
    pins: [(u32, bool); 4],
}

trait BoardOnABench {
    fn millisecond(&mut self, n: u64, script: &Millisecond) -> Seen;
}

/// Steps of the firmware's PWM in a period.
const PWM_STEPS: u16 = 3_984;

struct Native(Board);

impl BoardOnABench for Native {
    fn millisecond(&mut self, n: u64, script: &Millisecond) -> Seen {
        let step = Micros::from_millis(n);
        let drives = self.0.control_step(step, script.codes.map(AdcSample::from_reading));
        let mut at_us = 1_000 * n + ACT_US;
        let mut answers = Vec::new();
        for said in &script.speech {
            at_us += said.pause_us + 10;
            if said.damaged {
                self.0.line_error(Micros::new(at_us));
            } else {
                answers.extend(self.0.receive_byte(Micros::new(at_us), said.byte).into_iter().flatten());
            }
        }
        let pins =
            drives.map(DirPwm::from).map(|pins| (pins.compare(PWM_STEPS - 1).into(), pins.dir_is_high()));
        Seen { answers, pins }
    }
}

struct OnTheChip {
    bench: ChipBench,
    /// The first control step's sampling.
    start: Ticks,
}

impl OnTheChip {
    /// `codes` are for the first control step.
    fn power_on(codes: [u16; 4]) -> Self {
        // One chip to see when its first step samples, and another that then does the same.
        let mut scout = ChipBench::power_on(OWN);
        while scout.chip.adc_conversions(0).count == 0 {
            scout.run(Ticks::from_micros(1));
        }
        let start = scout.chip.adc_conversions(0).last_sampled;
        let mut chip = Self { bench: ChipBench::power_on(OWN), start };
        chip.set_codes(codes);
        chip
    }

    fn set_codes(&mut self, codes: [u16; 4]) {
        for (channel, code) in codes.into_iter().enumerate() {
            self.bench.chip.set_adc(channel, code);
        }
    }

    fn run_to(&mut self, n: u64, us: u64) {
        self.bench.chip.run_until(self.start + Ticks::from_micros(1_000 * n + us));
    }
}

impl BoardOnABench for OnTheChip {
    fn millisecond(&mut self, n: u64, script: &Millisecond) -> Seen {
        let mut at = self.start + Ticks::from_micros(1_000 * n + ACT_US);
        self.run_to(n, ACT_US);
        for said in &script.speech {
            at += Ticks::from_micros(said.pause_us) + CHARACTER;
            let errors = LineErrors { framing: said.damaged, ..LineErrors::NONE };
            self.bench.chip.uart_receive(BUS, at, said.byte, errors);
        }
        self.run_to(n, NOTE_US);
        let answers = self.bench.chip.take_transmitted(BUS).map(|character| character.byte).collect();
        let pins = std::array::from_fn(|valve| {
            let steps = self.bench.chip.pwm_duty(system_tests::chip_bench::PWM[valve]).unwrap_or(-1.0);
            let dir = self.bench.chip.pin_level(system_tests::chip_bench::DIR[valve]);
            ((steps * f64::from(PWM_STEPS)).round() as u32, dir == pneudrive_chip::Level::High)
        });
        Seen { answers, pins }
    }
}

/// Commands lie near the pressures, so that the valves are driven in part and not only fully.
fn speech(rng: &mut Pcg32, codes: [u16; 4], checks: bool) -> Speech {
    let commands = codes.map(|code| rng.random_range(code / 4 - 50..code / 4 + 50));
    let say = |bytes: &[u8]| -> Speech {
        bytes.iter().map(|&byte| Said { pause_us: 0, byte, damaged: false }).collect()
    };
    let request = |board| {
        let packet = packet(board, commands);
        if checks {
            let sequence = Sequence::new(commands[0] as u8 & 15);
            say(&CheckedPacket { packet, sequence }.encode(Direction::Request))
        } else {
            say(&packet.encode())
        }
    };
    match rng.random_range(0..10) {
        0..4 => request(OWN),
        4 => request(rng.random_range(0..4)),
        // Another exchange, from which nothing may be taken.
        5 => [request(2), say(&packet(2, commands).encode())].concat(),
        // Cut off, and then a whole one after a gap.
        6 => {
            let mut speech = request(OWN);
            speech.truncate(rng.random_range(1..10));
            let mut whole = request(OWN);
            whole[0].pause_us = rng.random_range(35..60);
            [speech, whole].concat()
        }
        // A pause, short of a gap or more, inside a request.
        7 => {
            let mut speech = request(OWN);
            speech[rng.random_range(1..10)].pause_us =
                if rng.random() { rng.random_range(0..22) } else { 35 };
            speech
        }
        8 => {
            let mut speech = request(OWN);
            speech[rng.random_range(0..10)].damaged = true;
            speech
        }
        _ => (0..rng.random_range(0..20))
            .map(|_| Said {
                pause_us: 0,
                byte: if rng.random() { 0xFF } else { rng.random() },
                damaged: false,
            })
            .collect(),
    }
}

/// Seven seconds: power-up vent, a host that does not check, its death, one that does; sensors that
/// come and go.
fn story(seed: u64) -> Vec<Millisecond> {
    let mut rng = Pcg32::seed_from_u64(seed);
    let mut levels = [410_u16; 4];
    let mut broken_until = [0_u64; 4];
    (0..7_000_u64)
        .map(|n| {
            for channel in 0..4 {
                if rng.random_range(0..300) == 0 {
                    levels[channel] = rng.random_range(410..3_600);
                }
                if rng.random_range(0..700) == 0 {
                    broken_until[channel] = n + rng.random_range(1..25);
                }
            }
            let noise: [u16; 4] = std::array::from_fn(|_| rng.random_range(0..9));
            let codes = std::array::from_fn(|channel| {
                if n < broken_until[channel] {
                    4_095 * (channel as u16 & 1)
                } else {
                    levels[channel] + noise[channel]
                }
            });
            let host_is_dead = (3_000..6_000).contains(&n);
            let speech = if host_is_dead { Vec::new() } else { speech(&mut rng, levels, n >= 6_000) };
            Millisecond { codes, speech }
        })
        .collect()
}

#[test]
fn native_board_and_chip_give_the_same_answers_and_drives() {
    let mut answers = 0;
    let mut levels = std::collections::BTreeSet::new();
    for seed in 0..2 {
        let board = Board::new(BoardConfig::ORIGINAL, Address::of_board(OWN));
        let mut native = Native(board.unwrap_or_else(|error| panic!("{error}")));
        // The chip's sensors change in the middle of a millisecond, for the step that follows.
        let script = story(seed);
        let mut chip = OnTheChip::power_on(script[0].codes);
        for (n, millisecond) in (0_u64..).zip(&script) {
            let expected = native.millisecond(n, millisecond);
            chip.run_to(n, ACT_US);
            if let Some(next) = script.get(n as usize + 1) {
                chip.set_codes(next.codes);
            }
            let got = chip.millisecond(n, millisecond);
            assert_eq!(got, expected, "seed {seed}, {n} ms after the first step");
            answers += got.answers.len() / 10;
            levels.extend(got.pins);
        }
    }
    println!("{answers} answers, {} different pin settings", levels.len());
    assert!(
        answers > 3_000 && levels.len() > 300,
        "the story is too dull: {answers} answers, {}",
        levels.len()
    );
}
