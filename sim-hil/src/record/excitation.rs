//! Set points over time: seeded sequences of holds, ramps and sweeps.

use core::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;

use crate::plant::noise::{Purpose, stream, uniform};

/// What the set points of every channel do, each with its own random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Excitation {
    /// Random levels held for 1 to 4 s.
    Steps,
    /// Random levels held for 0.15 to 0.4 s: separates lags and dead times.
    FastSteps,
    /// Amplitude-modulated pseudo-random sequence: random levels held for 0.1 to 1.2 s, mostly
    /// briefly.
    Aprbs,
    /// Sine sweeps of 10 s from 0.1 to 3 Hz with random centre and amplitude.
    Sine,
    /// Ramps to random levels in 0.5 to 4 s.
    Ramps,
    /// The whole range up and down in six levels, 2 s each, channels shifted by half a second.
    Staircase,
    /// Blocks of 12 s, each one of the above at random.
    Mixed,
}

/// Kinds a mixed excitation draws from.
const BLOCKS: [Excitation; 5] =
    [Excitation::Steps, Excitation::FastSteps, Excitation::Aprbs, Excitation::Sine, Excitation::Ramps];
const BLOCK_S: f64 = 12.0;
const SWEEP_S: f64 = 10.0;
const SWEEP_HZ: [f64; 2] = [0.1, 3.0];
const STAIRS: u32 = 6;
const STAIR_S: f64 = 2.0;

/// Set points of one channel, kPa gauge.
#[derive(Debug, Clone)]
pub struct SetPoints {
    kind: Excitation,
    block: Excitation,
    block_end_s: f64,
    low: f64,
    span: f64,
    shift_s: f64,
    rng: ChaCha8Rng,
    segment: Segment,
}

/// One piece of a set-point curve.
#[derive(Debug, Clone, Copy)]
struct Segment {
    start_s: f64,
    end_s: f64,
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    Ramp { from: f64, to: f64 },
    Sweep { centre: f64, amplitude: f64 },
}

impl SetPoints {
    /// The set points of the `place`-th channel between two gauge pressures in kPa.
    #[must_use]
    pub fn new(kind: Excitation, range_kpa: [f64; 2], seed: u64, place: usize) -> Self {
        let [low, high] = range_kpa;
        let segment = Segment { start_s: 0.0, end_s: 0.0, shape: Shape::Ramp { from: low, to: low } };
        Self {
            kind,
            block: kind,
            block_end_s: 0.0,
            low,
            span: high - low,
            shift_s: 0.5 * place as f64,
            rng: stream(seed, Purpose::Excitation, place),
            segment,
        }
    }

    /// The set point at `time_s`, kPa gauge. Times must not run backwards.
    pub fn at(&mut self, time_s: f64) -> f64 {
        if self.kind == Excitation::Staircase {
            return self.stair(time_s);
        }
        while time_s >= self.segment.end_s {
            self.next_segment();
        }
        self.segment.value(time_s)
    }

    fn stair(&self, time_s: f64) -> f64 {
        // Up 0..5, down 4..1: ten stairs a round.
        let round = 2 * (STAIRS - 1);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, far below 2^32"
        )]
        let stair = ((time_s + self.shift_s) / STAIR_S) as u32 % round;
        let level = if stair < STAIRS { stair } else { round - stair };
        self.low + self.span * f64::from(level) / f64::from(STAIRS - 1)
    }

    fn next_segment(&mut self) {
        let start_s = self.segment.end_s;
        if self.kind == Excitation::Mixed && start_s >= self.block_end_s {
            self.block = BLOCKS[self.pick(BLOCKS.len())];
            self.block_end_s = start_s + BLOCK_S;
        }
        let last = self.segment.value(start_s);
        let level = self.low + self.span * uniform(&mut self.rng);
        let hold = Shape::Ramp { from: level, to: level };
        let (seconds, shape) = match self.block {
            Excitation::FastSteps => (self.between(0.15, 0.4), hold),
            Excitation::Aprbs => (0.1 * (12.0_f64.ln() * uniform(&mut self.rng)).exp(), hold),
            Excitation::Sine => (SWEEP_S, self.sweep(level)),
            Excitation::Ramps => (self.between(0.5, 4.0), Shape::Ramp { from: last, to: level }),
            Excitation::Steps | Excitation::Staircase | Excitation::Mixed => (self.between(1.0, 4.0), hold),
        };
        self.segment = Segment { start_s, end_s: start_s + seconds, shape };
    }

    /// A sweep about `centre` that stays within the range.
    fn sweep(&mut self, centre: f64) -> Shape {
        let room = (centre - self.low).min(self.low + self.span - centre);
        Shape::Sweep { centre, amplitude: room * self.between(0.3, 1.0) }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * uniform(&mut self.rng)
    }

    fn pick(&mut self, count: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to less than count")]
        let index = (uniform(&mut self.rng) * count as f64) as usize;
        index.min(count - 1)
    }
}

impl Segment {
    fn value(&self, time_s: f64) -> f64 {
        let t = time_s - self.start_s;
        match self.shape {
            Shape::Ramp { from, to } => {
                let seconds = self.end_s - self.start_s;
                if seconds > 0.0 { from + (to - from) * (t / seconds).min(1.0) } else { to }
            }
            Shape::Sweep { centre, amplitude } => {
                // Exponential sweep: phase is the integral of f0 (f1/f0)^(t/T).
                let rate = (SWEEP_HZ[1] / SWEEP_HZ[0]).ln() / SWEEP_S;
                centre + amplitude * (TAU * SWEEP_HZ[0] / rate * (rate * t).exp_m1()).sin()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(kind: Excitation, seed: u64, place: usize) -> Vec<f64> {
        let mut points = SetPoints::new(kind, [50.0, 300.0], seed, place);
        (0..20_000).map(|k| points.at(0.01 * f64::from(k))).collect()
    }

    #[test]
    fn all_stay_in_the_range_and_use_it() {
        use clap::ValueEnum;
        for kind in Excitation::value_variants() {
            let x = run(*kind, 3, 1);
            let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            assert!(low >= 50.0 - 1e-9 && high <= 300.0 + 1e-9, "{kind:?}: {low} to {high}");
            assert!(low < 90.0 && high > 260.0, "{kind:?}: {low} to {high}");
        }
    }

    #[test]
    fn repeat_by_seed_and_differ_between_channels() {
        assert_eq!(run(Excitation::Mixed, 3, 1), run(Excitation::Mixed, 3, 1));
        assert_ne!(run(Excitation::Mixed, 3, 1), run(Excitation::Mixed, 4, 1));
        assert_ne!(run(Excitation::Mixed, 3, 1), run(Excitation::Mixed, 3, 2));
    }

    /// Steps change 1 to 4 s apart, fast steps 0.15 to 0.4 s apart.
    #[test]
    fn holds_have_their_lengths() {
        for (kind, shortest, longest) in
            [(Excitation::Steps, 0.99, 4.01), (Excitation::FastSteps, 0.139, 0.411)]
        {
            let x = run(kind, 9, 0);
            let changes: Vec<usize> = (1..x.len()).filter(|&k| (x[k] - x[k - 1]).abs() > 0.0).collect();
            assert!(changes.len() > 40);
            for pair in changes.windows(2) {
                let seconds = 0.01 * (pair[1] - pair[0]) as f64;
                assert!((shortest..longest).contains(&seconds), "{kind:?}: {seconds}");
            }
        }
    }
}
