//! Recordings of pressure regulators with their own loop, made without the toolkit and without the
//! truth plant.
//!
//! The regulator is a first-order lag of the command, stepped at 2 kHz with the explicit Euler
//! rule, behind or in front of one defect. Noise and rounding are those of a small industrial
//! sensor.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What is wrong with a regulator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Defect {
    /// Nothing.
    None,
    /// Seconds between command and reaction.
    DeadTime(f64),
    /// Time constant of a second lag, s.
    Lag(f64),
    /// Half the play between command and what is acted on, kPa.
    Hysteresis(f64),
    /// Change of the command below which nothing happens, kPa.
    DeadBand(f64),
    /// Largest rate of the pressure, kPa/s.
    RateLimit(f64),
    /// Time constant falling over time constant rising.
    Asymmetry(f64),
    /// Added to the command, kPa.
    Offset(f64),
}

/// Time constant of the healthy regulator, s.
pub const TIME_CONSTANT_S: f64 = 0.15;
/// Highest command, kPa.
pub const HIGHEST_KPA: f64 = 400.0;
const STEP_S: f64 = 0.0005;
/// Standard deviation of the noise, kPa, and the rounding of the readings, kPa.
const NOISE_KPA: f64 = 0.25;
const ROUNDING_KPA: f64 = 0.1;

/// A recording: `t_s`, one command and one pressure, `rate_hz` rows a second.
#[must_use]
pub fn recording(defect: Defect, seconds: f64, rate_hz: f64, seed: u64) -> String {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let commands = commands(&mut rng, seconds);
    let at = |t: f64| commands[whole(t.max(0.0) / STEP_S).min(commands.len() - 1)];
    let steps_per_row = whole(1.0 / (rate_hz * STEP_S));
    let rows = whole(seconds * rate_hz);
    let mut text = "t_s,b0_cmd0_kpa,b0_p0_kpa\n".to_owned();
    let (mut pressure, mut lagged, mut acted) = (commands[0], commands[0], commands[0]);
    if let Defect::Offset(offset) = defect {
        pressure += offset;
    }
    for row in 0..rows {
        // Sum of twelve uniform numbers: nearly normal with unit variance.
        let normal = (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let reading = ((pressure + NOISE_KPA * normal) / ROUNDING_KPA).round() * ROUNDING_KPA;
        // The command of a row holds until the next one.
        let row_s = row as f64 / rate_hz;
        text.push_str(&format!("{row_s:.4},{:.2},{reading:.1}\n", at(row_s)));
        for step in 0..steps_per_row {
            let t = row_s + step as f64 * STEP_S;
            let held = |t: f64| at((t * rate_hz + 1e-9).floor() / rate_hz);
            let command = held(t);
            let mut time_constant = TIME_CONSTANT_S;
            let target = match defect {
                Defect::DeadTime(delay) => held((t - delay).max(0.0)),
                Defect::Lag(second) => {
                    lagged += (command - lagged) * STEP_S / second;
                    lagged
                }
                Defect::Hysteresis(half) => {
                    acted = f64::clamp(acted, command - half, command + half);
                    acted
                }
                Defect::DeadBand(band) => {
                    if (command - acted).abs() >= band {
                        acted = command;
                    }
                    acted
                }
                Defect::Offset(offset) => command + offset,
                Defect::Asymmetry(ratio) => {
                    if command < pressure {
                        time_constant *= ratio;
                    }
                    command
                }
                Defect::None | Defect::RateLimit(_) => command,
            };
            let mut rate = (target - pressure) / time_constant;
            if let Defect::RateLimit(limit) = defect {
                rate = rate.clamp(-limit, limit);
            }
            pressure += rate * STEP_S;
        }
    }
    text
}

/// Commands every step: stretches of 10 s of large steps, small steps and ramps.
fn commands(rng: &mut Pcg64Mcg, seconds: f64) -> Vec<f64> {
    let mut list = vec![150.0; 2];
    while (list.len() as f64) * STEP_S < seconds {
        let (last, kind) = (list[list.len() - 1], (list.len() as f64 * STEP_S / 10.0) as u32 % 3);
        let level: f64 = match kind {
            0 => 20.0 + (HIGHEST_KPA - 20.0) * rng.random::<f64>(),
            1 => (last + 16.0 * (2.0 * rng.random::<f64>() - 1.0)).clamp(20.0, HIGHEST_KPA),
            _ => (last + 120.0 * (2.0 * rng.random::<f64>() - 1.0)).clamp(20.0, HIGHEST_KPA),
        };
        let hold = whole((0.3 + 1.2 * rng.random::<f64>()) / STEP_S);
        list.extend(
            (1..=hold)
                .map(|k| if kind == 2 { last + (level - last) * k as f64 / hold as f64 } else { level }),
        );
    }
    list
}

fn whole(value: f64) -> usize {
    value.round() as usize
}
