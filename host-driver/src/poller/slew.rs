//! From the set points that are wanted to those that are sent: the last gate before the bus.

use super::{BoardCommand, ChannelLimit};
use crate::time::saturating_ns;
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use std::time::Duration;

/// Clamps and ramps the set points of one board.
///
/// - No set point is above its channel's [`ChannelLimit::max_kpa`].
/// - It changes by at most [`ChannelLimit::max_rate_kpa_s`].
/// - After a pause it rises by at most [`SlewOptions::return_rate_kpa_s`] until what is wanted has
///   been reached. A pause is a vent, or a time without answers that is long enough for the board's
///   own command timeout. The ramp starts at the pressure that the board reports.
///
/// Venting is immediate: no rate applies to it.
#[derive(Debug, Clone)]
pub(super) struct Slew {
    highest: [Counts; CHANNELS],
    rate_counts_s: [f64; CHANNELS],
    return_rate_counts_s: [f64; CHANNELS],
    vent: Counts,
    pause_ns: u64,
    longest_step_ns: u64,
    /// What is sent, before it is rounded, counts.
    level: [f64; CHANNELS],
    stepped_ns: Option<u64>,
    answered_ns: Option<u64>,
    state: State,
}

/// Settings of a [`Slew`] that are no limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlewOptions {
    /// What the channels' counts mean.
    pub(super) scales: [SensorScale; CHANNELS],
    /// The count that vents every channel: at most [`Counts::ATMOSPHERE`].
    pub(super) vent: Counts,
    /// Fastest rise after a pause, kPa/s.
    pub(super) return_rate_kpa_s: f64,
    /// Longest time between two steps that is no pause; 0 where it is not known.
    pub(super) period: Duration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// What is wanted is followed.
    Following,
    /// The board has not answered for so long that it may have vented: it is sent 0 kPa until it
    /// answers.
    Away,
    /// After a pause, below what is wanted.
    Returning,
}

impl SlewOptions {
    /// A board that has not been heard for this long has been away, ns: a little less than the 500
    /// ms after which a board's own command timeout begins.
    pub(super) const PAUSE_NS: u64 = 400_000_000;
    /// The most time that one step of a ramp makes up for, ns: a host that stood still does not
    /// jump.
    const LONGEST_STEP_NS: u64 = 50_000_000;
}

impl Slew {
    /// For a board with these limits, vented.
    pub(super) fn new(limits: [ChannelLimit; CHANNELS], options: SlewOptions) -> Self {
        let period_ns = saturating_ns(options.period);
        let count_kpa = options.scales.map(|scale| scale.kpa_per_count());
        Self {
            highest: std::array::from_fn(|channel| limits[channel].highest(options.scales[channel])),
            rate_counts_s: std::array::from_fn(|channel| limits[channel].max_rate_kpa_s / count_kpa[channel]),
            return_rate_counts_s: count_kpa.map(|kpa| options.return_rate_kpa_s / kpa),
            vent: options.vent,
            pause_ns: SlewOptions::PAUSE_NS.max(3 * period_ns),
            longest_step_ns: SlewOptions::LONGEST_STEP_NS.max(2 * period_ns),
            level: levels([options.vent; CHANNELS]),
            stepped_ns: None,
            answered_ns: None,
            state: State::Following,
        }
    }

    /// 0 kPa for every channel.
    pub(super) fn vented(&self) -> BoardCommand {
        [self.vent; CHANNELS]
    }

    /// What is meant by a set point: up to [`Counts::ATMOSPHERE`], whoever gave it wants 0 kPa.
    pub(super) fn meant(&self, wanted: Counts) -> Counts {
        if wanted <= Counts::ATMOSPHERE { wanted.min(self.vent) } else { wanted }
    }

    /// What to send at `now_ns` when `wanted` is wanted. `vented` is for 0 kPa at once, whatever is
    /// wanted.
    pub(super) fn step(&mut self, now_ns: u64, wanted: BoardCommand, vented: bool) -> BoardCommand {
        let since_ns = self.stepped_ns.replace(now_ns).map_or(0, |then| now_ns.saturating_sub(then));
        let answered_ns = *self.answered_ns.get_or_insert(now_ns);
        if now_ns.saturating_sub(answered_ns) > self.pause_ns {
            self.state = State::Away;
        }
        if vented || self.state == State::Away {
            self.level = levels(self.vented());
            if self.state == State::Following {
                self.state = State::Returning;
            }
            return self.vented();
        }
        let seconds = since_ns.min(self.longest_step_ns) as f64 * 1e-9;
        let mut reached = true;
        for (channel, wanted) in wanted.into_iter().enumerate() {
            let wanted = f64::from(self.meant(wanted).min(self.highest[channel]).get());
            let rate = self.rate_counts_s[channel];
            let rise = if self.state == State::Returning {
                rate.min(self.return_rate_counts_s[channel])
            } else {
                rate
            };
            let level = &mut self.level[channel];
            // Where there is no limit, infinity times 0 s would be NaN.
            let most = |rate: f64| if rate.is_finite() { rate * seconds } else { f64::INFINITY };
            *level = wanted.clamp(*level - most(rate), *level + most(rise));
            reached &= *level >= wanted;
        }
        if reached {
            self.state = State::Following;
        }
        self.level.map(|level| Counts::saturating(level.round() as u16))
    }

    /// Whether the board has not been heard for so long that it is sent 0 kPa until it answers.
    pub(super) fn is_away(&self) -> bool {
        self.state == State::Away
    }

    /// For how long it has not been heard at `now_ns`.
    pub(super) fn unheard(&self, now_ns: u64) -> Duration {
        Duration::from_nanos(self.answered_ns.map_or(0, |then| now_ns.saturating_sub(then)))
    }

    /// The board answered at `now_ns` with these pressures.
    pub(super) fn answered(&mut self, now_ns: u64, pressures: [Counts; CHANNELS]) {
        self.answered_ns = Some(now_ns);
        if self.state == State::Away {
            self.state = State::Returning;
            for (channel, pressure) in pressures.into_iter().enumerate() {
                let start = pressure.clamp(self.vent.min(self.highest[channel]), self.highest[channel]);
                self.level[channel] = f64::from(start.get());
            }
        }
    }
}

fn levels(command: BoardCommand) -> [f64; CHANNELS] {
    command.map(|counts| f64::from(counts.get()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poller::VENTED;

    const MS: u64 = 1_000_000;
    const OPTIONS: SlewOptions = SlewOptions {
        scales: [SensorScale::ORIGINAL; CHANNELS],
        vent: Counts::ATMOSPHERE,
        return_rate_kpa_s: 100.0,
        period: Duration::ZERO,
    };

    fn counts(value: u16) -> BoardCommand {
        [Counts::saturating(value); CHANNELS]
    }

    fn slew(max_kpa: f64, max_rate_kpa_s: f64) -> Slew {
        Slew::new([ChannelLimit { max_kpa, max_rate_kpa_s }; CHANNELS], OPTIONS)
    }

    /// Steps every millisecond over `ms`, answered each time with `pressure`; what is sent on
    /// channel 0.
    fn run(slew: &mut Slew, ms: std::ops::Range<u64>, wanted: u16, pressure: u16) -> Vec<u16> {
        ms.map(|ms| {
            let sent = slew.step(ms * MS, counts(wanted), false);
            slew.answered(ms * MS, counts(pressure));
            sent[0].get()
        })
        .collect()
    }

    #[test]
    fn without_limits_everything_is_sent_at_once() {
        let mut slew = slew(f64::INFINITY, f64::INFINITY);
        assert_eq!(slew.step(5, counts(511), false), counts(511));
        assert_eq!(slew.step(5, counts(0), false), counts(0));
        assert_eq!(slew.step(6, counts(922), false), counts(922));
    }

    #[test]
    fn the_maximum_holds_and_the_rate_holds_both_ways() {
        // 84.1645 kPa/s are 100 counts a second.
        let mut slew = slew(200.0, 84.164_5);
        let up = run(&mut slew, 0..3_000, 1023, 102);
        assert_eq!((up[0], up[1_000], up[2_999]), (102, 202, 340), "200 kPa are 340.03 counts");
        assert!(up.windows(2).all(|pair| pair[1] - pair[0] <= 1));
        let down = run(&mut slew, 3_000..4_001, 102, 102);
        assert_eq!(down[1_000], 240);
    }

    #[test]
    fn venting_is_immediate_and_what_follows_is_a_ramp() {
        let mut slew = slew(f64::INFINITY, f64::INFINITY);
        assert_eq!(run(&mut slew, 0..2, 511, 300), [511, 511]);
        assert_eq!(slew.step(3 * MS, counts(511), true), VENTED);
        let back = run(&mut slew, 4..5_000, 511, 300);
        // 100 kPa/s are 118.8 counts a second.
        assert_eq!((back[0], back[1_000]), (102, 221));
        assert_eq!(back.last(), Some(&511));
        assert_eq!(slew.step(5_001 * MS, counts(800), false), counts(800), "the ramp is over");
    }

    #[test]
    fn a_board_that_was_away_returns_from_where_it_is() {
        let mut slew = slew(f64::INFINITY, f64::INFINITY);
        run(&mut slew, 0..10, 511, 511);
        // A few lost answers are no pause.
        assert_eq!(slew.step(300 * MS, counts(511), false), counts(511));
        slew.answered(300 * MS, counts(511));
        assert_eq!(slew.step(701 * MS, counts(511), false), VENTED, "away for 0.4 s");
        slew.answered(702 * MS, counts(400));
        let back = run(&mut slew, 703..1_704, 511, 400);
        assert_eq!((back[0], back[500], back[1_000]), (400, 460, 511));
        assert!(back.windows(2).all(|pair| pair[1] - pair[0] <= 1), "{back:?}");
    }

    #[test]
    fn a_slow_pace_is_no_pause() {
        let options = SlewOptions { period: Duration::from_secs(1), ..OPTIONS };
        let mut slew = Slew::new([ChannelLimit::NONE; CHANNELS], options);
        for second in 0..5 {
            assert_eq!(slew.step(second * 1_000 * MS, counts(300), false), counts(300));
            slew.answered(second * 1_000 * MS + MS, counts(300));
        }
    }

    /// The zero of channel 1 was found at 95 counts: what everybody calls 0 kPa would be 6 kPa
    /// there.
    #[test]
    fn zero_is_zero_and_a_limit_is_one_with_each_channels_own_scale() {
        let low = SensorScale::new(95.0, 0.8, 600.0).unwrap();
        let mut scales = OPTIONS.scales;
        scales[1] = low;
        let options = SlewOptions { scales, vent: Counts::saturating(95), ..OPTIONS };
        let mut slew = Slew::new([ChannelLimit { max_kpa: 80.0, max_rate_kpa_s: 80.0 }; CHANNELS], options);
        assert_eq!(slew.step(0, VENTED, false), counts(95));
        assert_eq!(slew.step(1, counts(300), true), counts(95));
        let sent = (2..3_000).map(|ms| {
            slew.answered(ms * MS, counts(102));
            slew.step(ms * MS, counts(300), false)
        });
        // 80 kPa are 197.5 counts nominally, and 195 on channel 1, which has 100 counts a second.
        assert_eq!(sent.last().unwrap().map(Counts::get), [197, 195, 197, 197]);
    }

    #[test]
    fn a_host_that_stood_still_does_not_jump() {
        let mut slew = slew(f64::INFINITY, 84.164_5);
        run(&mut slew, 0..10, 511, 102);
        let sent = slew.step(350 * MS, counts(511), false)[0].get();
        assert!(sent <= 103 + 5, "{sent}: 50 ms are 5 counts");
    }
}
