//! Every so many rows of a recording, with what the valves were told in between.

use super::{Channel, Drive, Flags, Joint, Recording};

impl Recording {
    /// Every `factor`-th row of each stretch, from its first one on. A drive is the mean over the
    /// rows that a kept one stands for, as a chamber adds up its flows; pressures, supply and
    /// angles are those of the kept row, commands too. `factor` of 0 or 1: as it is.
    #[must_use]
    pub fn thinned(&self, factor: usize) -> Self {
        let factor = factor.max(1);
        let mut breaks = Vec::new();
        let mut kept: Vec<(usize, usize)> = Vec::new();
        for segment in self.segments() {
            if !kept.is_empty() {
                breaks.push(kept.len());
            }
            let rows = segment.clone().step_by(factor);
            kept.extend(rows.map(|row| (row, (row + factor).min(segment.end))));
        }
        let thin = Thin { kept };
        Self {
            source: self.source.clone(),
            time_s: thin.kept.iter().map(|(row, _)| self.time_s[*row]).collect(),
            line: thin.kept.iter().map(|(row, _)| self.line[*row]).collect(),
            breaks,
            period_s: self.period_s * factor as f64,
            channels: self.channels.iter().map(|channel| thin.channel(channel)).collect(),
            joints: self.joints.iter().map(|joint| thin.joint(joint)).collect(),
            supply_kpa: self.supply_kpa.as_deref().map(|values| thin.at(values)),
            board_supplies: self.board_supplies.iter().map(|own| own.with(thin.at(&own.kpa))).collect(),
        }
    }
}

/// Kept rows, each with the row after the last that it stands for.
struct Thin {
    kept: Vec<(usize, usize)>,
}

impl Thin {
    fn at(&self, values: &[f32]) -> Vec<f32> {
        self.kept.iter().map(|(row, _)| values[*row]).collect()
    }

    fn mean(&self, values: &[f32]) -> Vec<f32> {
        let mean = |&(row, end): &(usize, usize)| values[row..end].iter().sum::<f32>() / (end - row) as f32;
        self.kept.iter().map(mean).collect()
    }

    fn channel(&self, channel: &Channel) -> Channel {
        let drive = channel.drive.as_ref().map(|drive| match drive {
            Drive::Spool(u) => Drive::Spool(self.mean(u)),
            Drive::Separate { fill, vent } => {
                Drive::Separate { fill: self.mean(fill), vent: self.mean(vent) }
            }
        });
        // The pressure is one row's; inputs are those of all that it stands for.
        let flags = |&(row, end): &(usize, usize)| {
            let mut flags = channel.flags[row];
            for input in [Flags::INPUT_HELD, Flags::INPUT_MISSING] {
                if channel.flags[row..end].iter().any(|flags| flags.contains(input)) {
                    flags.insert(input);
                }
            }
            flags
        };
        Channel {
            id: channel.id,
            command_kpa: channel.command_kpa.as_deref().map(|values| self.at(values)),
            pressure_kpa: channel.pressure_kpa.as_deref().map(|values| self.at(values)),
            drive,
            flags: self.kept.iter().map(flags).collect(),
        }
    }

    fn joint(&self, joint: &Joint) -> Joint {
        Joint {
            board: joint.board,
            qu_rad: joint.qu_rad.as_deref().map(|values| self.at(values)),
            qv_rad: joint.qv_rad.as_deref().map(|values| self.at(values)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, read};
    use super::*;

    /// 10 Hz for a second, time missing, another second; no drive in one row.
    fn recording() -> Recording {
        let times = (0..10).chain(50..60).map(|k| (k, f64::from(k) * 0.1));
        let drive = |k: i32| if k == 7 { String::new() } else { format!("{}", f64::from(k % 10) / 10.0) };
        let text: String = times.map(|(k, t)| format!("{t},{},{}\n", k, drive(k))).collect();
        let text = format!("t_s,b0_p0_kpa,b0_u0\n{text}");
        read("test.csv", text.as_bytes(), LoadOptions::default()).unwrap().recording
    }

    #[test]
    fn drives_are_means_and_pressures_those_of_the_kept_rows() {
        let thinned = recording().thinned(3);
        assert_eq!(thinned.breaks, [4]);
        let expected = [0.0, 0.3, 0.6, 0.9, 5.0, 5.3, 5.6, 5.9];
        assert!(thinned.time_s.iter().zip(expected).all(|(t, e)| (t - e).abs() < 1e-9));
        assert_eq!(thinned.channels[0].pressure_kpa.as_ref().unwrap()[..4], [0.0, 3.0, 6.0, 9.0]);
        let Some(Drive::Spool(u)) = &thinned.channels[0].drive else { panic!("no drive") };
        // The missing one of 0.7 held 0.6; the last row stands for itself.
        for (u, e) in u.iter().zip([0.1, 0.4, (0.6 + 0.6 + 0.8) / 3.0, 0.9, 0.1, 0.4, 0.7, 0.9]) {
            assert!((u - e).abs() < 1e-6, "{u} {e}");
        }
        let held: Vec<bool> =
            thinned.channels[0].flags.iter().map(|f| f.contains(Flags::INPUT_HELD)).collect();
        assert_eq!(held, [false, false, true, false, false, false, false, false]);
        assert!((thinned.period_s - 0.3).abs() < 1e-9);
    }

    #[test]
    fn by_one_nothing_changes() {
        let whole = recording();
        assert_eq!(whole.thinned(1), whole);
        assert_eq!(whole.thinned(0), whole);
    }
}
