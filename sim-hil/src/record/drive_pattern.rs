//! Drives of an open-loop recording.

use rand_chacha::ChaCha8Rng;

use crate::plant::noise::{Purpose, stream, uniform};

/// Shortest and longest hold, s.
const HOLD_S: [f64; 2] = [0.05, 0.8];
/// Share of holds at zero drive: leaks and creep show there.
const REST_SHARE: f64 = 0.15;

/// Random drives held for random times. Out of the pressure range the sign is the one that leads
/// back.
#[derive(Debug, Clone)]
pub struct DrivePattern {
    amplitude: f64,
    range_kpa: [f64; 2],
    rng: ChaCha8Rng,
    until_s: f64,
    drive: f64,
}

impl DrivePattern {
    /// The pattern of the `place`-th channel with drives up to `amplitude`.
    pub fn new(amplitude: f64, range_kpa: [f64; 2], seed: u64, place: usize) -> Self {
        let rng = stream(seed, Purpose::Excitation, place);
        Self { amplitude, range_kpa, rng, until_s: 0.0, drive: 0.0 }
    }

    /// The drive from `time_s` on, with the pressure measured there. Times must not run backwards.
    pub fn at(&mut self, time_s: f64, pressure_kpa: f64) -> f64 {
        let [low, high] = self.range_kpa;
        let leaving = (pressure_kpa < low && self.drive < 0.0) || (pressure_kpa > high && self.drive > 0.0);
        if time_s >= self.until_s || leaving {
            let hold = HOLD_S[0] * ((HOLD_S[1] / HOLD_S[0]).ln() * uniform(&mut self.rng)).exp();
            self.until_s = time_s + hold;
            let rest = uniform(&mut self.rng) < REST_SHARE;
            let size = self.amplitude * uniform(&mut self.rng);
            let up = uniform(&mut self.rng) < 0.5;
            let up = if pressure_kpa < low {
                true
            } else if pressure_kpa > high {
                false
            } else {
                up
            };
            self.drive = if rest {
                0.0
            } else if up {
                size
            } else {
                -size
            };
        }
        self.drive
    }
}
