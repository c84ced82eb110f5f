//! What is commanded, and when.

use crate::line_fit::mean;
use crate::{CHANNELS, Samples};
use std::fmt;

/// Set points of one board over time: first all at 0 kPa, then one channel after the other up to
/// its level, to wherever its pressure then is (so that the valve closes), half way down, and down.
/// The other channels stay at 0 kPa meanwhile.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Highest set point of each channel, kPa.
    levels_kpa: [f64; CHANNELS],
    /// How many times as long as usual everything takes.
    stretch: f64,
}

/// When a channel is commanded what, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Phases {
    /// Up to its level.
    pub(crate) fill_s: f64,
    /// To where the pressure is: the board's loop has nothing to do.
    pub(crate) closed_s: f64,
    /// Down to half of the level.
    pub(crate) half_s: f64,
    /// Down to 0 kPa.
    pub(crate) vent_s: f64,
    /// The end.
    pub(crate) end_s: f64,
}

/// A plan that cannot be.
#[derive(Debug, Clone, PartialEq)]
pub enum PlanError {
    /// A level is too low for rates to be told from noise, or no number.
    Level {
        /// The channel.
        channel: usize,
        /// Its level, kPa.
        kpa: f64,
    },
    /// Times outside 0.5 to 10 times the usual.
    Stretch(f64),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level { channel, kpa } => write!(
                f,
                "channel {channel}: a check up to {kpa:.1} kPa tells nothing; expected at least {} kPa",
                Plan::LEAST_KPA
            ),
            Self::Stretch(stretch) => {
                write!(f, "times are to be stretched {stretch}-fold; expected 0.5 to 10")
            }
        }
    }
}

impl std::error::Error for PlanError {}

impl Plan {
    /// The lowest level that is worth a check, kPa: the board's loop drives its valve fully only
    /// from an error of 34 kPa on.
    pub const LEAST_KPA: f64 = 80.0;
    /// All channels at 0 kPa before anything is measured: boards vent for 2 s after power-up.
    const SETTLE_S: f64 = 2.5;
    /// All channels at 0 kPa, being measured.
    const REST_S: f64 = 2.0;
    const FILL_S: f64 = 1.2;
    const CLOSED_S: f64 = 1.5;
    const HALF_S: f64 = 1.2;
    const VENT_S: f64 = 1.2;
    /// The pressure at which a valve is closed is the mean of the last so many seconds before.
    const BEFORE_CLOSED_S: f64 = 0.1;
    /// Farther than this from its level a pressure is not held: the chamber has not arrived, kPa.
    const NEAR_LEVEL_KPA: f64 = 10.0;

    /// A plan up to `levels_kpa`; `stretch` is 1 for chambers that fill within a second, more for
    /// larger ones.
    ///
    /// # Errors
    /// A level below [`LEAST_KPA`](Self::LEAST_KPA), or times that are out of range.
    pub fn new(levels_kpa: [f64; CHANNELS], stretch: f64) -> Result<Self, PlanError> {
        // Written so that NaN is refused.
        if !(0.5..=10.0).contains(&stretch) {
            return Err(PlanError::Stretch(stretch));
        }
        match levels_kpa.iter().position(|&kpa| !(kpa >= Self::LEAST_KPA && kpa.is_finite())) {
            Some(channel) => Err(PlanError::Level { channel, kpa: levels_kpa[channel] }),
            None => Ok(Self { levels_kpa, stretch }),
        }
    }

    /// How long it takes, s: 24.9 s unless it is stretched.
    pub fn seconds(&self) -> f64 {
        self.phases(CHANNELS - 1).end_s
    }

    /// What is commanded at `t_s`, kPa; 0 before the beginning and after the end. `so_far` is what
    /// was answered before, which says where pressures are held.
    pub fn command_kpa(&self, t_s: f64, so_far: &Samples) -> [f64; CHANNELS] {
        std::array::from_fn(|channel| {
            let phases = self.phases(channel);
            match t_s {
                _ if t_s < phases.fill_s || t_s >= phases.vent_s => 0.0,
                _ if t_s < phases.closed_s => self.levels_kpa[channel],
                _ if t_s < phases.half_s => self.held_kpa(channel, so_far),
                _ => self.half_kpa(channel),
            }
        })
    }

    /// Where a channel's pressure is when its valve is to close; its level if it has not got there.
    pub(crate) fn held_kpa(&self, channel: usize, so_far: &Samples) -> f64 {
        let (level, closed_s) = (self.levels_kpa[channel], self.phases(channel).closed_s);
        let last = so_far.between(channel, closed_s - Self::BEFORE_CLOSED_S * self.stretch, closed_s);
        let mean = mean(&last).map_or(f64::NAN, |mean| mean.value);
        if (mean - level).abs() <= Self::NEAR_LEVEL_KPA { mean } else { level }
    }

    /// Highest set point of each channel, kPa.
    pub fn levels_kpa(&self) -> [f64; CHANNELS] {
        self.levels_kpa
    }

    pub(crate) fn level_kpa(&self, channel: usize) -> f64 {
        self.levels_kpa[channel]
    }

    pub(crate) fn half_kpa(&self, channel: usize) -> f64 {
        0.5 * self.levels_kpa[channel]
    }

    /// Begin and end of the time in which all channels rest, s.
    pub(crate) fn rest(&self) -> (f64, f64) {
        (Self::SETTLE_S * self.stretch, (Self::SETTLE_S + Self::REST_S) * self.stretch)
    }

    pub(crate) fn phases(&self, channel: usize) -> Phases {
        let half = Self::FILL_S + Self::CLOSED_S;
        let each = half + Self::HALF_S + Self::VENT_S;
        let fill = Self::SETTLE_S + Self::REST_S + each * channel as f64;
        let at = |t: f64| t * self.stretch;
        Phases {
            fill_s: at(fill),
            closed_s: at(fill + Self::FILL_S),
            half_s: at(fill + half),
            vent_s: at(fill + half + Self::HALF_S),
            end_s: at(fill + each),
        }
    }

    pub(crate) fn stretch(&self) -> f64 {
        self.stretch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_channel_at_a_time_is_above_0_and_none_above_its_level() {
        let levels = [100.0, 120.0, 150.0, 80.0];
        let plan = Plan::new(levels, 1.0).unwrap();
        assert!((plan.seconds() - 24.9).abs() < 1e-9);
        let nothing = Samples::default();
        let mut highest = [0.0_f64; CHANNELS];
        for step in -100..2_600 {
            let command = plan.command_kpa(f64::from(step) * 0.01, &nothing);
            assert!(command.iter().filter(|&&kpa| kpa > 0.0).count() <= 1, "{command:?}");
            highest = std::array::from_fn(|channel| highest[channel].max(command[channel]));
        }
        assert_eq!(highest, levels);
        assert_eq!(plan.command_kpa(plan.seconds(), &nothing), [0.0; 4]);
        // Held where the pressure is, unless it is far away.
        let (closed_s, mut samples) = (plan.phases(1).closed_s, Samples::default());
        (0..200).for_each(|row| {
            samples.push(closed_s - 0.2 + 0.001 * f64::from(row), levels, [0.0, 123.0, 0.0, 0.0])
        });
        assert!((plan.command_kpa(closed_s + 0.1, &samples)[1] - 123.0).abs() < 1e-9);
        assert_eq!(plan.held_kpa(0, &samples), 100.0);
        assert!(Plan::new([79.0; 4], 1.0).is_err() && Plan::new([f64::NAN; 4], 1.0).is_err());
        assert!(Plan::new([100.0; 4], 11.0).is_err());
    }
}
