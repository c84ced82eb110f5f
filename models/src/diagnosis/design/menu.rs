//! Excitations that a board can follow: what can be played as a next experiment.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::diagnosis::resampling::generator;

/// Time between two commands, s.
pub const PERIOD_S: f64 = 0.02;
/// At the start all channels are vented: boards do not obey for two seconds after power-up, they
/// vent.
const REST_S: f64 = 3.0;
/// Length of most excitations, s.
const SHORT_S: f64 = 48.0;
/// Length of those that wait for something slow, s.
const LONG_S: f64 = 120.0;
/// Half the size of a small movement, as a part of the range.
const SMALL: f64 = 0.06;

/// One entry of the menu.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excitation {
    /// Random levels over the whole range, briefly held.
    FastSteps,
    /// Random levels over the whole range, held until the pressure has settled.
    WideSteps,
    /// Small steps about a few levels.
    SmallSteps,
    /// The whole range up and down, slowly.
    SlowRamps,
    /// Small slow ramps up and down about a few levels.
    SmallRamps,
    /// Sines of many frequencies at once.
    Multisine,
    /// Each channel in turn, the others held.
    OneAtATime,
    /// All channels the same.
    Together,
    /// Levels held for long.
    Holds,
    /// One short pattern again and again.
    Repeats,
}

impl Excitation {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::FastSteps,
        Self::WideSteps,
        Self::SmallSteps,
        Self::SlowRamps,
        Self::SmallRamps,
        Self::Multisine,
        Self::OneAtATime,
        Self::Together,
        Self::Holds,
        Self::Repeats,
    ];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FastSteps => "fast_steps",
            Self::WideSteps => "wide_steps",
            Self::SmallSteps => "small_steps",
            Self::SlowRamps => "slow_ramps",
            Self::SmallRamps => "small_ramps",
            Self::Multisine => "multisine",
            Self::OneAtATime => "one_at_a_time",
            Self::Together => "together",
            Self::Holds => "holds",
            Self::Repeats => "repeats",
        }
    }

    /// What it does, for people.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::FastSteps => "steps over the whole range, held for 0.15 to 0.5 s",
            Self::WideSteps => "steps over the whole range, held for 1 to 3 s",
            Self::SmallSteps => "small steps about a few levels",
            Self::SlowRamps => "slow ramps over the whole range, up and down",
            Self::SmallRamps => "small slow ramps up and down about a few levels",
            Self::Multisine => "sines from 0.1 to 5 Hz at once",
            Self::OneAtATime => "one channel stepping at a time, the others held",
            Self::Together => "all channels stepping together",
            Self::Holds => "levels held for 12 s each",
            Self::Repeats => "one pattern of steps repeated every 10 s",
        }
    }

    /// Length, s.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::Holds | Self::Repeats => LONG_S,
            _ => SHORT_S,
        }
    }

    /// Does it take more than one channel?
    #[must_use]
    pub fn needs_several(self) -> bool {
        matches!(self, Self::OneAtATime | Self::Together)
    }

    /// Commands of channel number `channel` of `channels` every 20 ms, kPa gauge: 0 at first, then
    /// between `low` and `high`.
    #[must_use]
    pub fn commands(self, channel: usize, channels: usize, [low, high]: [f64; 2]) -> Vec<f64> {
        let shared = matches!(self, Self::Together);
        let mut shape = Shape::new(self, if shared { 0 } else { channel });
        let rows = rows(self.seconds());
        (0..rows)
            .map(|k| {
                let t = k as f64 * PERIOD_S - REST_S;
                if t < 0.0 {
                    return 0.0;
                }
                let part = shape.at(t, channel, channels).clamp(0.0, 1.0);
                // Whole hundredths, as they are written.
                ((low + (high - low) * part) * 100.0).round() / 100.0
            })
            .collect()
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few thousand
fn rows(seconds: f64) -> usize {
    (seconds / PERIOD_S).round() as usize + 1
}

/// Where one channel is in its excitation, as a part of the range.
struct Shape {
    kind: Excitation,
    rng: Pcg64Mcg,
    level: f64,
    until_s: f64,
    phases: Vec<f64>,
}

/// Frequencies of the multisine, Hz.
const SINES: [f64; 8] = [0.1, 0.23, 0.41, 0.73, 1.3, 2.1, 3.3, 5.0];

impl Shape {
    fn new(kind: Excitation, channel: usize) -> Self {
        let mut rng = generator(100 + channel as u64);
        let phases = SINES.iter().map(|_| std::f64::consts::TAU * rng.random::<f64>()).collect();
        Self { kind, rng, level: 0.0, until_s: 0.0, phases }
    }

    fn at(&mut self, t: f64, channel: usize, channels: usize) -> f64 {
        // Channels are shifted against each other, so that they draw at different times.
        let shifted = t + 1.7 * channel as f64;
        let slow = [0.25, 0.55, 0.85, 0.4][usize_of(shifted / 12.0) % 4];
        match self.kind {
            Excitation::FastSteps | Excitation::Together => self.steps(t, 0.15, 0.5),
            Excitation::WideSteps => self.steps(t, 1.0, 3.0),
            Excitation::SmallSteps => {
                if t >= self.until_s {
                    self.until_s = t + 0.7;
                    self.level = if self.rng.random::<bool>() { SMALL } else { -SMALL };
                }
                slow + self.level
            }
            Excitation::SlowRamps => triangle(shifted / 16.0),
            Excitation::SmallRamps => slow + SMALL * (2.0 * triangle(shifted / 4.0) - 1.0),
            Excitation::Multisine => {
                let sum: f64 = SINES
                    .iter()
                    .zip(&self.phases)
                    .map(|(f, phase)| (std::f64::consts::TAU * f * t + phase).sin() / f.sqrt())
                    .sum();
                let scale: f64 = SINES.iter().map(|f| 1.0 / f.sqrt()).sum();
                0.5 + 0.9 * sum / scale
            }
            Excitation::OneAtATime => {
                if usize_of(t / 4.0) % channels.max(1) == channel {
                    self.steps(t, 0.3, 1.0)
                } else {
                    0.5
                }
            }
            Excitation::Holds => {
                [0.1, 0.9, 0.5, 1.0, 0.3, 0.7, 0.0, 0.8, 0.2, 0.6][usize_of(shifted / 12.0) % 10]
            }
            Excitation::Repeats => {
                let place = usize_of((shifted % 10.0) / 1.25);
                [0.1, 0.9, 0.4, 0.7, 0.2, 1.0, 0.6, 0.3][place % 8]
            }
        }
    }

    fn steps(&mut self, t: f64, shortest: f64, longest: f64) -> f64 {
        if t >= self.until_s {
            self.until_s = t + shortest + (longest - shortest) * self.rng.random::<f64>();
            self.level = self.rng.random::<f64>();
        }
        self.level
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // times from 0 to minutes
fn usize_of(value: f64) -> usize {
    value as usize
}

/// 0 to 1 and back over one period.
fn triangle(periods: f64) -> f64 {
    let phase = periods.rem_euclid(1.0);
    if phase < 0.5 { 2.0 * phase } else { 2.0 - 2.0 * phase }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_excitation_stays_in_its_range_and_moves() {
        for kind in Excitation::ALL {
            let commands: Vec<Vec<f64>> = (0..2).map(|c| kind.commands(c, 2, [20.0, 220.0])).collect();
            for channel in &commands {
                assert_eq!(channel.len(), rows(kind.seconds()));
                let (rest, moving) = channel.split_at(150);
                let (low, high) =
                    moving.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
                assert!(low >= 20.0 && high <= 220.0 && high - low > 100.0, "{kind:?}: {low} to {high}");
                assert!(rest.iter().all(|p| *p <= 0.0), "{kind:?} starts vented");
            }
            assert_eq!(commands[0] == commands[1], kind == Excitation::Together, "{kind:?}");
            assert_eq!(kind.commands(1, 2, [20.0, 220.0]), commands[1], "{kind:?} repeats");
        }
    }
}
