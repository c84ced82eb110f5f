//! Parts of a recording, and a recording at another rate. What was masked stays masked.

use std::ops::Range;

use super::quality::{self, QualityReport};
use super::{Channel, Drive, Flags, Joint, Loaded, Recording};

/// Most rows of a resampled recording: a day at 500 Hz.
const MOST_ROWS: f64 = 50e6;

/// Why there is no such part.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutError {
    /// Too little is left.
    #[error("{rows} row(s) are left; a recording needs 2 at least")]
    TooFewRows {
        /// How many.
        rows: usize,
    },
    /// A rate that cannot be meant.
    #[error(
        "{rate_hz} Hz is no sampling rate for this recording: it must be above 0 and make 2 to 50 million rows"
    )]
    Rate {
        /// What was asked for.
        rate_hz: f64,
    },
}

impl Loaded {
    /// Some of the rows.
    ///
    /// # Errors
    /// [`CutError::TooFewRows`].
    pub fn rows(&self, rows: Range<usize>) -> Result<Self, CutError> {
        let rows = rows.start..rows.end.min(self.recording.rows());
        if rows.len() < 2 {
            return Err(CutError::TooFewRows { rows: rows.len() });
        }
        let breaks = self.recording.breaks.iter();
        let breaks = breaks.filter(|at| rows.start < **at && **at < rows.end).map(|at| at - rows.start);
        let breaks = breaks.collect();
        let take = Take { rows: rows.map(|row| Place { before: row, after: row, share: 0.0 }).collect() };
        Ok(take.of(self, breaks))
    }

    /// The same at another rate: in each stretch without missing time from its first row on, every
    /// 1 / `rate_hz`. Pressures, supply and angles lie on the line between their neighbours,
    /// commands and drives hold; what is masked on either side is masked. Nothing is filtered: what
    /// is faster than half the new rate folds over.
    ///
    /// # Errors
    /// [`CutError::Rate`].
    pub fn resampled(&self, rate_hz: f64) -> Result<Self, CutError> {
        let time_s = &self.recording.time_s;
        let wrong = CutError::Rate { rate_hz };
        let expected = self.recording.duration_s() * rate_hz;
        if !(rate_hz > 0.0 && (1.0..MOST_ROWS).contains(&expected)) {
            return Err(wrong);
        }
        let (mut places, mut breaks) = (Vec::new(), Vec::new());
        for segment in self.recording.segments() {
            if !places.is_empty() {
                breaks.push(places.len());
            }
            let (first_s, last_s) = (time_s[segment.start], time_s[segment.end - 1]);
            let mut before = segment.start;
            // Half a microsecond, so that no row is missed by a rounding.
            for at_s in
                (0u32..).map(|k| first_s + f64::from(k) / rate_hz).take_while(|at| *at <= last_s + 5e-7)
            {
                while before + 1 < segment.end && time_s[before + 1] <= at_s + 5e-7 {
                    before += 1;
                }
                let step_s = time_s.get(before + 1).map_or(1.0, |next| next - time_s[before]);
                let share = (at_s - time_s[before]) / step_s;
                // On a row, that row alone counts.
                let on_row = share * step_s < 1e-6 || before + 1 == segment.end;
                places.push(match on_row {
                    true => Place { before, after: before, share: 0.0 },
                    false => Place { before, after: before + 1, share },
                });
            }
        }
        if places.len() < 2 {
            return Err(wrong);
        }
        Ok(Take { rows: places }.of(self, breaks))
    }
}

/// Where a new row lies: so far from one old row to another.
#[derive(Clone, Copy)]
struct Place {
    before: usize,
    after: usize,
    share: f64,
}

/// The new rows.
struct Take {
    rows: Vec<Place>,
}

impl Take {
    fn of(&self, loaded: &Loaded, breaks: Vec<usize>) -> Loaded {
        let old = &loaded.recording;
        let time = |place: &Place| {
            let (from, to) = (old.time_s[place.before], old.time_s[place.after]);
            from + place.share * (to - from)
        };
        let time_s: Vec<f64> = self.rows.iter().map(time).collect();
        let line: Vec<u32> = self.rows.iter().map(|place| old.line[place.before]).collect();
        let sampling = quality::sampling(&time_s);
        let recording = Recording {
            source: old.source.clone(),
            line,
            breaks,
            period_s: sampling.rate_hz.recip(),
            channels: old.channels.iter().map(|channel| self.channel(channel)).collect(),
            joints: old.joints.iter().map(|joint| self.joint(joint)).collect(),
            supply_kpa: old.supply_kpa.as_deref().map(|values| self.lines(values)),
            board_supplies: old.board_supplies.iter().map(|own| own.with(self.lines(&own.kpa))).collect(),
            time_s,
        };
        let (from_s, to_s) = (recording.time_s[0], recording.time_s[recording.rows() - 1]);
        let here = |finding: &&quality::Finding| {
            finding.spans.is_empty() || finding.spans.iter().any(|s| s.to_s >= from_s && s.from_s <= to_s)
        };
        let quality = QualityReport {
            rows_read: loaded.quality.rows_read,
            rows_kept: recording.rows(),
            sampling,
            findings: loaded.quality.findings.iter().filter(here).cloned().collect(),
        };
        Loaded { recording, quality }
    }

    fn channel(&self, channel: &Channel) -> Channel {
        let drive = channel.drive.as_ref().map(|drive| match drive {
            Drive::Spool(u) => Drive::Spool(self.held(u)),
            Drive::Separate { fill, vent } => {
                Drive::Separate { fill: self.held(fill), vent: self.held(vent) }
            }
        });
        let flags = |place: &Place| channel.flags[place.before] | channel.flags[place.after];
        let pressure_kpa = channel.pressure_kpa.as_deref().map(|values| self.lines(values));
        let mut flags: Vec<Flags> = self.rows.iter().map(flags).collect();
        // An input that holds is that of the row before.
        for (flag, place) in flags.iter_mut().zip(&self.rows) {
            if !channel.flags[place.before].contains(Flags::INPUT_MISSING) {
                flag.remove(Flags::INPUT_MISSING);
            }
        }
        Channel {
            id: channel.id,
            command_kpa: channel.command_kpa.as_deref().map(|values| self.held(values)),
            pressure_kpa,
            drive,
            flags,
        }
    }

    fn joint(&self, joint: &Joint) -> Joint {
        Joint {
            board: joint.board,
            qu_rad: joint.qu_rad.as_deref().map(|values| self.lines(values)),
            qv_rad: joint.qv_rad.as_deref().map(|values| self.lines(values)),
        }
    }

    fn held(&self, values: &[f32]) -> Vec<f32> {
        self.rows.iter().map(|place| values[place.before]).collect()
    }

    #[allow(clippy::cast_possible_truncation)] // columns are kept in single precision
    fn lines(&self, values: &[f32]) -> Vec<f32> {
        let value = |place: &Place| {
            let (from, to) = (f64::from(values[place.before]), f64::from(values[place.after]));
            (from + place.share * (to - from)) as f32
        };
        self.rows.iter().map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, read};
    use super::*;

    fn loaded() -> Loaded {
        // 10 Hz from 0 to 1 s; then time is missing until 5 s. One pressure is missing at 0.5 s.
        let times = (0..=10).map(|k| f64::from(k) * 0.1).chain((0..=10).map(|k| 5.0 + f64::from(k) * 0.1));
        let row = |t: f64| {
            let pressure = if (t - 0.5).abs() < 1e-9 { String::new() } else { format!("{}", 10.0 * t) };
            format!("{t},{},{pressure}\n", if t < 0.75 { 0 } else { 100 })
        };
        let text: String = times.map(row).collect();
        let text = format!("t_s,b0_cmd0_kpa,b0_p0_kpa\n{text}");
        read("test.csv", text.as_bytes(), LoadOptions::default()).unwrap()
    }

    #[test]
    fn rows_keep_their_masks_breaks_and_lines() {
        let whole = loaded();
        let part = whole.rows(4..14).unwrap().recording;
        assert_eq!((part.rows(), part.breaks.as_slice()), (10, &[7][..]));
        assert_eq!(part.line[0], whole.recording.line[4]);
        assert!(part.channels[0].flags[1].contains(Flags::PRESSURE_MISSING));
        assert_eq!(part.channels[0].pressure_kpa.as_ref().unwrap()[0], 4.0);
        assert_eq!(whole.rows(3..4), Err(CutError::TooFewRows { rows: 1 }));
    }

    #[test]
    fn at_twice_the_rate_pressures_lie_between_and_commands_hold() {
        let fine = loaded().resampled(20.0).unwrap().recording;
        assert_eq!((fine.rows(), fine.breaks.as_slice()), (42, &[21][..]));
        let channel = &fine.channels[0];
        let pressure = channel.pressure_kpa.as_ref().unwrap();
        assert!((pressure[5] - 2.5).abs() < 1e-6);
        // 0.75 s is between 0.7 s (0 kPa) and 0.8 s (100 kPa).
        assert_eq!(channel.command_kpa.as_ref().unwrap()[15..17], [0.0, 100.0]);
        // The missing pressure of 0.5 s is missing from 0.45 to 0.55 s, no further.
        let usable: Vec<bool> = channel.flags[7..14].iter().map(|flags| flags.pressure_usable()).collect();
        assert_eq!(usable, [true, true, false, false, false, true, true]);
    }

    #[test]
    fn its_own_rate_changes_nothing_and_no_rate_is_refused() {
        let whole = loaded();
        let same = whole.resampled(10.0).unwrap().recording;
        assert_eq!(same.channels[0].command_kpa, whole.recording.channels[0].command_kpa);
        assert_eq!(same.channels[0].flags, whole.recording.channels[0].flags);
        for rate_hz in [0.0, -1.0, f64::NAN, 1e-3, 1e12] {
            assert!(whole.resampled(rate_hz).is_err(), "{rate_hz}");
        }
    }
}
