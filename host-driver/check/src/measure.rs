//! Values out of readings.

use crate::line_fit::{Estimate, Line, deviation, mean};
use crate::missing::Missing;
use crate::plan::Phases;
use crate::{CHANNELS, Plan, Quantity, Samples};

/// What was measured of a channel; `estimate` is the value and its standard error, or why there is
/// none.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// What.
    pub quantity: Quantity,
    /// Of which channel.
    pub channel: usize,
    /// Value and standard error, in the quantity's unit.
    pub estimate: Result<(f64, f64), Missing>,
}

impl Measured {
    /// Whether another try may give a value: nothing but this machine or the line prevented it.
    pub fn was_disturbed(&self) -> bool {
        self.estimate == Err(Missing::Busy)
    }
}

/// What two tries of the same plan found, as [`measure`] returns it: what was disturbed in the
/// first is taken from the second.
pub fn completed(first: Vec<Measured>, second: Vec<Measured>) -> Vec<Measured> {
    let pairs = first.into_iter().zip(second);
    pairs.map(|(first, second)| if first.was_disturbed() { second } else { first }).collect()
}

/// Error from which on the board's loop drives its valve fully, kPa: 40 counts.
const FULL_DRIVE_KPA: f64 = 36.0;
/// Nearer than this to a set point is there: beyond the valve's dead band, before the loop brakes,
/// kPa.
const ARRIVED_KPA: f64 = 8.0;
/// A set point that takes longer than this to change is ramped, s: rates are then the ramp's.
const AT_ONCE_S: f64 = 0.02;
/// Share of its rows that a line needs.
const ENOUGH: f64 = 0.6;
/// Longest time without a row where a pressure arrives, s: what the pressure does then is what is
/// measured.
const UNSEEN_S: f64 = 0.02;

/// Measures everything that the plan is made for; what could not be measured says why.
pub fn measure(plan: &Plan, samples: &Samples) -> Vec<Measured> {
    let period_s = samples.period_s();
    let of = |channel| Channel { plan, samples, channel, phases: plan.phases(channel), period_s };
    (0..CHANNELS).flat_map(|channel| of(channel).all()).collect()
}

struct Channel<'a> {
    plan: &'a Plan,
    samples: &'a Samples,
    channel: usize,
    phases: Phases,
    /// Usual time between two rows, s.
    period_s: f64,
}

type Found = Result<Estimate, Missing>;

impl Channel<'_> {
    fn all(&self) -> Vec<Measured> {
        let (rest, phases) = (self.plan.rest(), self.phases);
        let at_rest = self.between(rest.0, rest.1);
        let (fill_rate, dead_time) = self.rise();
        let fill_edge = self.stopped(phases.fill_s, phases.closed_s, self.plan.level_kpa(self.channel));
        let vent_edge = self.stopped(phases.half_s, phases.vent_s, self.plan.half_kpa(self.channel));
        let both = |combine: fn(f64, f64) -> f64, share: f64| -> Found {
            let (fill, vent) = (fill_edge.clone()?, vent_edge.clone()?);
            let error = share * fill.error.hypot(vent.error);
            Ok(Estimate { value: combine(fill.value, vent.value), error })
        };
        let found = [
            (Quantity::Zero, self.few(mean(&at_rest))),
            (Quantity::Noise, self.few(deviation(&at_rest))),
            (Quantity::Reached, self.at_end(phases.closed_s, self.plan.level_kpa(self.channel))),
            (Quantity::FillRate, fill_rate),
            (Quantity::VentRate, self.fall_rate()),
            (Quantity::DeadTime, dead_time),
            (Quantity::Threshold, both(|fill, vent| vent - fill, 1.0)),
            (Quantity::Centre, both(|fill, vent| 0.5 * (fill + vent), 0.5)),
            (Quantity::Leak, self.leak()),
            (Quantity::Hold, self.at_end(phases.vent_s, self.plan.half_kpa(self.channel))),
            (Quantity::Crosstalk, self.crosstalk()),
        ];
        let measured = found.into_iter().map(|(quantity, found)| Measured {
            quantity,
            channel: self.channel,
            estimate: found.map(|estimate| (estimate.value, estimate.error)),
        });
        measured.collect()
    }

    fn between(&self, from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
        self.samples.between(self.channel, from_s, to_s)
    }

    fn s(&self, seconds: f64) -> f64 {
        seconds * self.plan.stretch()
    }

    /// When the set point changed; an error where it was ramped, or never sent, or sent nobody
    /// knows when.
    fn step(&self, at_s: f64, to_kpa: f64) -> Result<f64, Missing> {
        match self.samples.commanded(self.channel, at_s, to_kpa) {
            None if self.samples.longest_gap_s(at_s - 0.1, at_s + self.s(1.0)) > 0.5 * self.s(1.0) => {
                Err(Missing::Busy)
            }
            None => Err(Missing::Because("the set point was not sent".to_owned())),
            Some((_, took_s)) if took_s > AT_ONCE_S.max(4.0 * self.period_s) => {
                Err(Missing::Because("a limit ramps the set point: the rate is the ramp's".to_owned()))
            }
            Some((at_s, _)) => Ok(at_s),
        }
    }

    /// Fill rate, and dead time, of the rise to the level.
    fn rise(&self) -> (Found, Found) {
        let level = self.plan.level_kpa(self.channel);
        let begun = match self.step(self.phases.fill_s, level) {
            Ok(begun) => begun,
            Err(why) => return (Err(why.clone()), Err(why)),
        };
        let before = mean(&self.between(begun - self.s(0.3), begun));
        let top = (level - FULL_DRIVE_KPA).min(0.65 * level);
        let rise = |low, high| self.crossing((begun, self.phases.half_s), 1.0, low, high);
        let rate = rise(0.12 * level, top).map(|line| line.slope);
        let dead_time = before.ok_or_else(|| self.missing()).and_then(|before| {
            // The board got the command at some time between this row and the next one.
            if self.samples.is_late_at(begun, self.period_s) {
                return Err(Missing::Busy);
            }
            let crossed = rise(0.08 * level, 0.5 * level)?.crosses(before);
            Ok(Estimate { value: 1e3 * (crossed.value - begun), error: 1e3 * crossed.error })
        });
        (rate, dead_time)
    }

    /// The fall from half the level to 0 kPa.
    fn fall_rate(&self) -> Found {
        let half = self.plan.half_kpa(self.channel);
        let begun = self.step(self.phases.vent_s, 0.0)?;
        let bottom = FULL_DRIVE_KPA.max(0.5 * half).min(0.7 * half);
        Ok(self.crossing((begun, self.phases.end_s), -1.0, -0.9 * half, -bottom)?.slope)
    }

    /// The line through the readings, times `sign`, of a rise: from when they first are above `low`
    /// to before they first are above `high`.
    fn crossing(&self, (from_s, to_s): (f64, f64), sign: f64, low: f64, high: f64) -> Result<Line, Missing> {
        let all: Vec<_> = self.between(from_s, to_s).into_iter().map(|(t, kpa)| (t, sign * kpa)).collect();
        let first = |than: f64| all.iter().position(|(_, y)| *y > than);
        let (Some(from), Some(to)) = (first(low), first(high)) else { return Err(self.missing()) };
        let (from_s, to_s) = (all[from].0, all[to].0);
        let timed = self.samples.timed(self.channel, from_s, to_s, self.period_s);
        // A rise within a gap is not seen at all.
        let longest_s = UNSEEN_S.max(4.0 * self.period_s).max(0.1 * (to_s - from_s));
        if timed.len() < self.enough(to_s - from_s) || self.samples.longest_gap_s(from_s, to_s) > longest_s {
            return Err(Missing::Busy);
        }
        let points: Vec<_> = timed.into_iter().map(|(t, kpa)| (t, sign * kpa)).collect();
        Line::through(&points).ok_or_else(Missing::few)
    }

    /// Rows that so many seconds need.
    fn enough(&self, seconds: f64) -> usize {
        (ENOUGH * seconds / self.period_s) as usize
    }

    /// Where the pressure stands beside the set point when the valve has just stopped.
    fn stopped(&self, from_s: f64, to_s: f64, set_point_kpa: f64) -> Found {
        let phase = self.between(from_s, to_s);
        let near = |(_, kpa): &&(f64, f64)| (kpa - set_point_kpa).abs() < ARRIVED_KPA;
        let Some(&(arrived_s, _)) = phase.iter().find(near) else {
            if self.samples.longest_gap_s(from_s, to_s) > self.s(0.5) {
                return Err(Missing::Busy);
            }
            return Err(Missing::Because(format!("{set_point_kpa:.0} kPa was not reached")));
        };
        let unseen_s = self.samples.longest_gap_s(arrived_s - 2.0 * self.period_s, arrived_s);
        if unseen_s > UNSEEN_S.max(4.0 * self.period_s) {
            return Err(Missing::Busy);
        }
        let stopped_s = arrived_s + self.s(0.15);
        let edge = self.mean_of(stopped_s, (stopped_s + self.s(0.15)).min(to_s))?;
        Ok(Estimate { value: edge.value - set_point_kpa, ..edge })
    }

    /// Fall of the pressure while it is itself the set point.
    fn leak(&self) -> Found {
        let Phases { closed_s, half_s, .. } = self.phases;
        let (level, held) = (self.plan.level_kpa(self.channel), self.at_end(closed_s, 0.0)?.value);
        if (held - level).abs() > ARRIVED_KPA {
            return Err(Missing::Because(format!("{level:.0} kPa was not reached")));
        }
        let from_s = closed_s + self.s(0.1);
        let points = self.samples.timed(self.channel, from_s, half_s, self.period_s);
        if points.len() < self.enough(half_s - from_s) {
            return Err(Missing::Busy);
        }
        let slope = Line::through(&points).ok_or_else(Missing::few)?.slope;
        Ok(Estimate { value: -slope.value, ..slope })
    }

    /// Deviation from the set point at the end of its phase.
    fn at_end(&self, end_s: f64, set_point_kpa: f64) -> Found {
        let estimate = self.mean_of(end_s - self.s(0.4), end_s)?;
        Ok(Estimate { value: estimate.value - set_point_kpa, ..estimate })
    }

    /// Mean of the readings over some time, if there are enough of them.
    fn mean_of(&self, from_s: f64, to_s: f64) -> Found {
        let points = self.between(from_s, to_s);
        if points.len() < self.enough(to_s - from_s) {
            return Err(Missing::Busy);
        }
        self.few(mean(&points))
    }

    fn few(&self, estimate: Option<Estimate>) -> Found {
        estimate.ok_or_else(|| self.missing())
    }

    /// Why there are too few readings: nothing was asked, or the pressure was not there.
    fn missing(&self) -> Missing {
        let (from_s, to_s) = (self.phases.fill_s, self.phases.end_s);
        if self.between(from_s, to_s).len() < self.enough(to_s - from_s) {
            Missing::Busy
        } else {
            Missing::few()
        }
    }

    /// How far the channels that are commanded 0 kPa come away from where they were: at the most
    /// over 40 ms. The one that was tested just before still falls, and is left out.
    fn crosstalk(&self) -> Found {
        const WINDOW_S: f64 = 0.04;
        let Phases { fill_s, vent_s, .. } = self.phases;
        let mut largest: Option<Estimate> = None;
        let rests = |&other: &usize| other != self.channel && other + 1 != self.channel;
        for other in (0..CHANNELS).filter(rests) {
            let before = self.few(mean(&self.samples.between(other, fill_s - self.s(0.3), fill_s)))?;
            let during = self.samples.between(other, fill_s, vent_s);
            let mut rest = during.as_slice();
            while let Some(&(first_s, _)) = rest.first() {
                let (window, later) = rest.split_at(rest.partition_point(|(t, _)| *t < first_s + WINDOW_S));
                rest = later;
                // A mean of a few readings is away by their noise.
                if window.len() < self.enough(WINDOW_S) {
                    continue;
                }
                let Some(level) = mean(window) else { continue };
                let away = Estimate {
                    value: (level.value - before.value).abs(),
                    error: level.error.hypot(before.error),
                };
                if largest.is_none_or(|so_far| away.value > so_far.value) {
                    largest = Some(away);
                }
            }
        }
        self.few(largest)
    }
}

#[cfg(test)]
mod tests;
