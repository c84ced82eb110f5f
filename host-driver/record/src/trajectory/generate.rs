//! Trajectories that are made, not recorded: excitation for tests and fits.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::f64::consts::PI;

/// What a channel's set point does. All stay within `low_kpa` to `high_kpa`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Up and down again in steps of equal size.
    Steps,
    /// One sine, from the middle.
    Sine,
    /// A sine whose frequency rises exponentially from one to the other.
    Sweep,
    /// Amplitude-modulated pseudo-random binary signal: random levels, held for random times
    /// (O. Nelles, Nonlinear System Identification, 2001, 17.7). Channels are independent.
    Aprbs,
}

/// A trajectory to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What it does.
    pub shape: Shape,
    /// Its length, s.
    pub seconds: f64,
    /// Lowest and highest set point of each channel, kPa gauge.
    pub channels: Vec<(f64, f64)>,
    /// Steps and APRBS: how long a level is held, on the mean, s. Sine: its period, s. Sweep: the
    /// period at its beginning, s.
    pub hold_s: f64,
    /// Sweep: the period at its end, s.
    pub last_period_s: f64,
    /// APRBS: which of the random ones.
    pub seed: u64,
}

/// Levels of [`Shape::Steps`] on the way up, the lowest included.
const LEVELS: usize = 6;
/// Time between rows of sines, s. Rates of set points are limited by the boards' loops, not by
/// this.
const ROW_S: f64 = 0.02;

impl Plan {
    /// Rows: the time, s, and a set point for each channel, kPa gauge. The last row goes back to
    /// the lowest.
    pub fn rows(&self) -> Vec<(f64, Vec<f64>)> {
        let mut rows = match self.shape {
            Shape::Steps => self.steps(),
            Shape::Sine | Shape::Sweep => self.sines(),
            Shape::Aprbs => self.aprbs(),
        };
        rows.push((self.seconds, self.channels.iter().map(|(low, _)| *low).collect()));
        rows
    }

    /// `part` of the way from low to high, for every channel.
    fn at(&self, part: f64) -> Vec<f64> {
        self.channels.iter().map(|(low, high)| low + part * (high - low)).collect()
    }

    fn steps(&self) -> Vec<(f64, Vec<f64>)> {
        let up = 0..LEVELS;
        let stair: Vec<usize> = up.clone().chain((1..LEVELS - 1).rev()).collect();
        let count = (self.seconds / self.hold_s).ceil() as usize;
        let level = |n: usize| stair[n % stair.len()] as f64 / (LEVELS - 1) as f64;
        (0..count).map(|n| (n as f64 * self.hold_s, self.at(level(n)))).collect()
    }

    fn sines(&self) -> Vec<(f64, Vec<f64>)> {
        let (first_hz, last_hz) = (1.0 / self.hold_s, 1.0 / self.last_period_s);
        let growth = (last_hz / first_hz).ln() / self.seconds;
        let turns = |t: f64| match self.shape {
            // The integral of first_hz exp(growth t).
            Shape::Sweep if growth.abs() > 1e-12 => first_hz * ((growth * t).exp() - 1.0) / growth,
            _ => first_hz * t,
        };
        let count = (self.seconds / ROW_S).ceil() as usize;
        let times = (0..count).map(|n| n as f64 * ROW_S);
        times.map(|t| (t, self.at(0.5 + 0.5 * (2.0 * PI * turns(t)).sin()))).collect()
    }

    /// In whole milliseconds, as tables have their times: two steps less than one apart would be
    /// two rows at the same time.
    fn aprbs(&self) -> Vec<(f64, Vec<f64>)> {
        let mut random = Pcg32::seed_from_u64(self.seed);
        let mut now: Vec<f64> = self.at(0.0);
        let mut until_ms = vec![0_u64; now.len()];
        let mut rows = Vec::new();
        let mut at_ms = 0;
        while at_ms as f64 * 1e-3 < self.seconds {
            for (channel, (low, high)) in self.channels.iter().enumerate() {
                if until_ms[channel] <= at_ms {
                    now[channel] = low + random.random::<f64>() * (high - low);
                    // From half to one and a half of the mean, so that channels do not step
                    // together.
                    let held_ms = 1e3 * self.hold_s * (0.5 + random.random::<f64>());
                    until_ms[channel] = at_ms + (held_ms.round() as u64).max(1);
                }
            }
            rows.push((at_ms as f64 * 1e-3, now.clone()));
            at_ms = until_ms.iter().copied().min().unwrap_or(u64::MAX);
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(shape: Shape) -> Plan {
        let channels = vec![(10.0, 60.0), (0.0, 100.0)];
        Plan { shape, seconds: 20.0, channels, hold_s: 1.0, last_period_s: 0.25, seed: 7 }
    }

    #[test]
    fn every_shape_stays_within_its_limits_and_uses_them() {
        for shape in [Shape::Steps, Shape::Sine, Shape::Sweep, Shape::Aprbs] {
            let rows = plan(shape).rows();
            assert_eq!(rows[0].0, 0.0);
            assert!(rows.windows(2).all(|pair| pair[1].0 > pair[0].0), "{shape:?}: times rise");
            assert_eq!(rows.last(), Some(&(20.0, vec![10.0, 0.0])), "{shape:?}");
            for (channel, (low, high)) in [(10.0, 60.0), (0.0, 100.0)].into_iter().enumerate() {
                let values: Vec<f64> = rows.iter().map(|(_, kpa)| kpa[channel]).collect();
                assert!(values.iter().all(|kpa| (low..=high).contains(kpa)), "{shape:?}: {values:?}");
                let (least, most) =
                    values.iter().fold((f64::MAX, 0.0_f64), |(a, b), kpa| (a.min(*kpa), b.max(*kpa)));
                assert!(
                    least - low < 0.2 * (high - low) && high - most < 0.2 * (high - low),
                    "{shape:?}: {least} {most}"
                );
            }
        }
    }

    /// 20 s at 1 Hz and then at up to 4 Hz: upward passages through the middle count the periods.
    #[test]
    fn a_sweep_has_as_many_periods_as_its_frequencies_say() {
        let passages = |shape| {
            let rows = plan(shape).rows();
            let above: Vec<bool> = rows[1..rows.len() - 1].iter().map(|(_, kpa)| kpa[1] > 50.0).collect();
            above.windows(2).filter(|pair| !pair[0] && pair[1]).count()
        };
        assert_eq!(passages(Shape::Sine), 19);
        // The mean of 1 to 4 Hz, exponentially: 3 / ln 4 = 2.164 Hz, 43.3 periods.
        assert_eq!(passages(Shape::Sweep), 43);
    }

    /// As written to a table. 16 channels of 60 s: some step within the same millisecond.
    #[test]
    fn times_rise_in_milliseconds_too() {
        let channels = vec![(40.0, 250.0); 16];
        let plan = Plan { seconds: 60.0, channels, hold_s: 2.0, ..plan(Shape::Aprbs) };
        let times: Vec<u64> = plan.rows().iter().map(|(t, _)| (t * 1e3).round() as u64).collect();
        assert!(times.len() > 400 && times.windows(2).all(|pair| pair[1] > pair[0]), "{times:?}");
    }

    #[test]
    fn random_levels_are_those_of_their_seed_and_channels_differ() {
        let rows = plan(Shape::Aprbs).rows();
        assert_eq!(rows, plan(Shape::Aprbs).rows());
        assert_ne!(rows, Plan { seed: 8, ..plan(Shape::Aprbs) }.rows());
        let changes =
            |channel: usize| rows.windows(2).filter(|pair| pair[0].1[channel] != pair[1].1[channel]).count();
        // About one a second; the last row takes both back.
        assert!(
            (12..=30).contains(&changes(0)) && (12..=30).contains(&changes(1)),
            "{} {}",
            changes(0),
            changes(1)
        );
        assert!(rows.len() > 1 + changes(0).max(changes(1)), "they do not step together");
    }
}
