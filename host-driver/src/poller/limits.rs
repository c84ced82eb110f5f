//! How much pressure a channel may be commanded, and how fast the command may change.

use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use std::collections::BTreeMap;
use thiserror::Error;

/// Limits of one channel's set point. Infinite by default: then the sensor's full scale is the
/// limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelLimit {
    /// Highest set point, kPa gauge.
    pub max_kpa: f64,
    /// Fastest change of the set point, rising or falling, kPa/s. Venting is not a change of the
    /// set point: it is never slowed down.
    pub max_rate_kpa_s: f64,
}

impl ChannelLimit {
    /// No limit but the sensor's.
    pub const NONE: Self = Self { max_kpa: f64::INFINITY, max_rate_kpa_s: f64::INFINITY };

    /// The stricter of both, value by value.
    #[must_use]
    pub fn stricter(self, other: Self) -> Self {
        Self {
            max_kpa: self.max_kpa.min(other.max_kpa),
            max_rate_kpa_s: self.max_rate_kpa_s.min(other.max_rate_kpa_s),
        }
    }

    /// The highest count whose pressure is not above the limit; any count where the limit is not
    /// below the sensor's full scale.
    pub fn highest(&self, scale: SensorScale) -> Counts {
        if self.max_kpa >= scale.full_scale_kpa() {
            return Counts::MAX;
        }
        let nearest = scale.counts(self.max_kpa.max(0.0)).unwrap_or(Counts::ATMOSPHERE);
        let above = scale.kpa(nearest) > self.max_kpa && nearest > Counts::ATMOSPHERE;
        if above { Counts::saturating(nearest.get() - 1) } else { nearest }
    }

    fn check(&self) -> Result<(), LimitError> {
        // Written so that NaN is refused.
        if !(self.max_kpa >= 0.0) {
            return Err(LimitError::Max(self.max_kpa));
        }
        if !(self.max_rate_kpa_s > 0.0) {
            return Err(LimitError::Rate(self.max_rate_kpa_s));
        }
        Ok(())
    }
}

impl Default for ChannelLimit {
    fn default() -> Self {
        Self::NONE
    }
}

/// Limits of all channels of all boards.
///
/// They are enforced twice. Whoever takes set points from outside (command line, trajectory, page,
/// Python, ROS) refuses those above the maximum with [`AboveLimit`]; the poller clamps and ramps
/// whatever reaches it, so that no way in goes around them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits {
    usual: ChannelLimit,
    boards: BTreeMap<u8, [ChannelLimit; CHANNELS]>,
}

impl Limits {
    /// The same for every channel.
    ///
    /// # Errors
    /// A maximum that is negative or NaN, or a rate that is not above 0.
    pub fn everywhere(limit: ChannelLimit) -> Result<Self, LimitError> {
        limit.check()?;
        Ok(Self { usual: limit, boards: BTreeMap::new() })
    }

    /// Limits of one channel, instead of those that it had.
    ///
    /// # Errors
    /// As for [`everywhere`](Self::everywhere), or there is no such channel.
    pub fn set(&mut self, board: u8, channel: usize, limit: ChannelLimit) -> Result<(), LimitError> {
        limit.check()?;
        let usual = self.usual;
        let channels = self.boards.entry(board).or_insert([usual; CHANNELS]);
        *channels.get_mut(channel).ok_or(LimitError::NoSuchChannel(channel))? = limit;
        Ok(())
    }

    /// With every channel limited by `limit` too: of both the stricter holds.
    ///
    /// # Errors
    /// As for [`everywhere`](Self::everywhere).
    pub fn and(mut self, limit: ChannelLimit) -> Result<Self, LimitError> {
        limit.check()?;
        self.usual = self.usual.stricter(limit);
        for channel in self.boards.values_mut().flatten() {
            *channel = channel.stricter(limit);
        }
        Ok(self)
    }

    /// Those of a board's channels 0 to 3.
    pub fn of(&self, board: u8) -> [ChannelLimit; CHANNELS] {
        self.boards.get(&board).copied().unwrap_or([self.usual; CHANNELS])
    }

    /// Whether a set point in kPa gauge may be commanded.
    ///
    /// # Errors
    /// It is above the channel's maximum.
    pub fn check(&self, board: u8, channel: usize, kpa: f64) -> Result<(), AboveLimit> {
        let max_kpa = self.of(board).get(channel).map_or(f64::INFINITY, |limit| limit.max_kpa);
        if kpa > max_kpa { Err(AboveLimit { board, channel, kpa, max_kpa }) } else { Ok(()) }
    }

    /// The same for a set point in counts; one that is above the maximum only because pressures are
    /// rounded to counts is taken (the poller sends the count below).
    ///
    /// # Errors
    /// As for [`check`](Self::check).
    pub fn check_counts(
        &self,
        board: u8,
        channel: usize,
        counts: Counts,
        scale: SensorScale,
    ) -> Result<(), AboveLimit> {
        let kpa = scale.kpa(counts);
        self.check(board, channel, kpa - 0.5 * scale.kpa_per_count())
            .map_err(|refused| AboveLimit { kpa, ..refused })
    }
}

/// A set point that is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "{kpa:.1} kPa for channel {channel} of board {board} is above its limit of {max_kpa} kPa; choose a lower set point, \
     or raise the limit where it is set (command line or rig file)"
)]
#[non_exhaustive]
pub struct AboveLimit {
    /// The board's number.
    pub board: u8,
    /// The channel, 0 to 3.
    pub channel: usize,
    /// The set point, kPa gauge.
    pub kpa: f64,
    /// The highest that is allowed, kPa gauge.
    pub max_kpa: f64,
}

/// A limit that makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum LimitError {
    /// Not a pressure.
    #[error("a highest pressure of {0} kPa: expected a number of kPa gauge from 0 on")]
    Max(f64),
    /// Not a rate.
    #[error("a fastest change of {0} kPa/s: expected a number above 0")]
    Rate(f64),
    /// There is no such channel.
    #[error("no channel {0}: a board has channels 0 to 3")]
    NoSuchChannel(usize),
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCALE: SensorScale = SensorScale::ORIGINAL;

    fn limit(max_kpa: f64, max_rate_kpa_s: f64) -> ChannelLimit {
        ChannelLimit { max_kpa, max_rate_kpa_s }
    }

    #[test]
    fn the_highest_count_is_never_above_the_limit() {
        for tenths in 0..=6_894 {
            let max_kpa = f64::from(tenths) / 10.0;
            let highest = limit(max_kpa, 1.0).highest(SCALE);
            // 0 kPa lies between two counts; the one below it vents.
            assert!(SCALE.kpa(highest) <= max_kpa, "{max_kpa}: {highest:?}");
            let next = Counts::saturating(highest.get() + 1);
            assert!(SCALE.kpa(next) > max_kpa, "{max_kpa}: {highest:?}");
        }
        assert_eq!(limit(690.0, 1.0).highest(SCALE), Counts::MAX);
        assert_eq!(ChannelLimit::NONE.highest(SCALE), Counts::MAX);
    }

    #[test]
    fn of_two_limits_the_stricter_holds_for_each_channel() {
        let mut limits = Limits::everywhere(limit(300.0, 1_000.0)).unwrap();
        limits.set(1, 2, limit(100.0, f64::INFINITY)).unwrap();
        let limits = limits.and(limit(200.0, 50.0)).unwrap();
        assert_eq!(limits.of(0), [limit(200.0, 50.0); 4]);
        assert_eq!(limits.of(1)[2], limit(100.0, 50.0));
        assert_eq!(limits.of(1)[3], limit(200.0, 50.0));
    }

    #[test]
    fn a_refusal_names_board_channel_and_limit() {
        let mut limits = Limits::default();
        limits.set(2, 1, limit(150.0, f64::INFINITY)).unwrap();
        assert_eq!(limits.check(2, 1, 150.0), Ok(()));
        assert_eq!(limits.check(2, 0, 600.0), Ok(()));
        let refused = limits.check(2, 1, 150.1).unwrap_err();
        assert!(
            refused
                .to_string()
                .starts_with("150.1 kPa for channel 1 of board 2 is above its limit of 150 kPa")
        );
        // 150 kPa is 280.6 counts, so it is commanded as 281, which is 150.3 kPa.
        assert_eq!(limits.check_counts(2, 1, SCALE.counts(150.0).unwrap(), SCALE), Ok(()));
        assert!(limits.check_counts(2, 1, Counts::saturating(282), SCALE).is_err());
    }

    #[test]
    fn limits_that_make_no_sense_are_refused() {
        for (max_kpa, rate) in [(-1.0, 1.0), (f64::NAN, 1.0), (1.0, 0.0), (1.0, -1.0), (1.0, f64::NAN)] {
            assert!(Limits::everywhere(limit(max_kpa, rate)).is_err(), "{max_kpa}, {rate}");
        }
        assert_eq!(Limits::default().set(0, 4, ChannelLimit::NONE), Err(LimitError::NoSuchChannel(4)));
    }
}
