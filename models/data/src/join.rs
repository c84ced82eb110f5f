//! Several recordings of one rig as one, each a stretch of its own.

use super::{Channel, ChannelId, Drive, Joint, Recording, Source};

/// Time between two recordings in the joined one, s: nobody knows how long it was, only that no
/// simulation runs across.
const PAUSE_S: f64 = 2.0;

/// Recordings that do not belong together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum JoinError {
    /// Not the same channels.
    #[error(
        "{first} has the channels {first_channels} and {second} has {second_channels}: recordings that are diagnosed together need the same ones; choose some (--channels, in Python channels=)"
    )]
    Channels {
        /// One file.
        first: String,
        /// Its channels.
        first_channels: String,
        /// The other file.
        second: String,
        /// Its channels.
        second_channels: String,
    },
    /// The same file again: what is measured once would count as measured twice.
    #[error("{second} is {first} once more (the same SHA-256): give each recording once")]
    Same {
        /// One file.
        first: String,
        /// The other file.
        second: String,
    },
    /// A column that only one of them has.
    #[error(
        "{without} has no {what}, which {with} has: recordings that are diagnosed together need the same columns; remove it from the one or record it in the other"
    )]
    Columns {
        /// What is missing.
        what: String,
        /// The file that has it.
        with: String,
        /// The file that does not.
        without: String,
    },
}

/// Is every row given once? Parts of one recording are no repetition.
///
/// # Errors
/// [`JoinError::Same`] naming two that share rows of the same file.
pub fn each_once(recordings: &[Recording]) -> Result<(), JoinError> {
    let ends = |recording: &Recording| Some((*recording.line.first()?, *recording.line.last()?));
    for (k, second) in recordings.iter().enumerate() {
        let repeated = recordings[..k].iter().find(|first| {
            let rows = ends(first).zip(ends(second));
            first.source.sha256 == second.source.sha256 && rows.is_some_and(|(a, b)| a.0 <= b.1 && b.0 <= a.1)
        });
        if let Some(first) = repeated {
            let (first, second) = (first.source.file.clone(), second.source.file.clone());
            return Err(JoinError::Same { first, second });
        }
    }
    Ok(())
}

/// What is to be said where only some of several recordings have the drive of a channel: joined,
/// they are [simulated from their commands](Recording::followed_by).
#[must_use]
pub fn half_drives(recordings: &[Recording]) -> Option<String> {
    let (first, others) = recordings.split_first()?;
    let lacks = |a: &Recording, b: &Recording| {
        let mut channels = a.channels.iter().zip(&b.channels);
        channels.any(|(a, b)| a.drive.is_some() && b.drive.is_none())
    };
    let found = |other: &Recording| {
        let pair = if lacks(first, other) { (first, other) } else { (other, first) };
        lacks(pair.0, pair.1).then(|| (pair.0.source.file.clone(), pair.1.source.file.clone()))
    };
    let (with, without) = others.iter().find_map(found)?;
    Some(format!(
        "{with} has drives, and {without} has none: together they are simulated from their commands, which tells less than {with} alone."
    ))
}

impl Recording {
    /// This recording with another behind it, as a stretch of its own.
    ///
    /// Both need the same channels and columns, with one exception: where only one has drives and
    /// both have commands, the drives are left out, so that both are simulated from commands.
    ///
    /// # Errors
    /// [`JoinError`] when they do not match.
    pub fn followed_by(mut self, mut next: Self) -> Result<Self, JoinError> {
        self.check(&next)?;
        leave_out_half_drives(&mut self, &mut next);
        let rows = self.rows();
        let origin = next.time_s.first().copied().unwrap_or(0.0);
        let offset = self.time_s.last().copied().unwrap_or(0.0) + PAUSE_S - origin;
        self.time_s.extend(next.time_s.iter().map(|t| t + offset));
        self.line.extend(next.line);
        self.breaks.push(rows);
        self.breaks.extend(next.breaks.iter().map(|row| row + rows));
        // The coarser of two rates is the one that all is said about.
        self.period_s = self.period_s.max(next.period_s);
        for (channel, more) in self.channels.iter_mut().zip(next.channels) {
            append(&mut channel.command_kpa, more.command_kpa);
            append(&mut channel.pressure_kpa, more.pressure_kpa);
            match (&mut channel.drive, more.drive) {
                (Some(Drive::Spool(u)), Some(Drive::Spool(v))) => u.extend(v),
                (Some(Drive::Separate { fill, vent }), Some(Drive::Separate { fill: f, vent: v })) => {
                    fill.extend(f);
                    vent.extend(v);
                }
                _ => {}
            }
            channel.flags.extend(more.flags);
        }
        for (joint, more) in self.joints.iter_mut().zip(next.joints) {
            append(&mut joint.qu_rad, more.qu_rad);
            append(&mut joint.qv_rad, more.qv_rad);
        }
        append(&mut self.supply_kpa, next.supply_kpa);
        for (own, more) in self.board_supplies.iter_mut().zip(next.board_supplies) {
            own.kpa.extend(more.kpa);
        }
        self.source = Source {
            file: format!("{}, {}", self.source.file, next.source.file),
            sha256: format!("{}, {}", self.source.sha256, next.source.sha256),
            bytes: self.source.bytes + next.source.bytes,
        };
        Ok(self)
    }

    fn check(&self, next: &Self) -> Result<(), JoinError> {
        let ids = |r: &Self| r.channels.iter().map(|c| c.id).collect::<Vec<ChannelId>>();
        let names = |r: &Self| ids(r).iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        if ids(self) != ids(next) {
            return Err(JoinError::Channels {
                first: self.source.file.clone(),
                first_channels: names(self),
                second: next.source.file.clone(),
                second_channels: names(next),
            });
        }
        let both = |what: String, a: bool, b: bool| {
            if a == b {
                return Ok(());
            }
            let (with, without) = if a { (self, next) } else { (next, self) };
            Err(JoinError::Columns {
                what,
                with: with.source.file.clone(),
                without: without.source.file.clone(),
            })
        };
        both("supply_kpa".to_owned(), self.supply_kpa.is_some(), next.supply_kpa.is_some())?;
        let measuring = |r: &Self| r.board_supplies.iter().map(|own| own.board).collect::<Vec<_>>();
        if measuring(self) != measuring(next) {
            let more = measuring(self).len() >= measuring(next).len();
            both("supply pressure (b{n}_supply_kpa) of some board".to_owned(), more, !more)?;
        }
        let boards = |r: &Self| {
            let of = |j: &Joint| (j.board, j.qu_rad.is_some(), j.qv_rad.is_some());
            r.joints.iter().map(of).collect::<Vec<_>>()
        };
        if boards(self) != boards(next) {
            let more = boards(self).len() >= boards(next).len();
            both("joint angle (b{n}_qu_rad, b{n}_qv_rad) of some board".to_owned(), more, !more)?;
        }
        for (a, b) in self.channels.iter().zip(&next.channels) {
            both(a.id.pressure_column(), a.pressure_kpa.is_some(), b.pressure_kpa.is_some())?;
            let commands = (a.command_kpa.is_some(), b.command_kpa.is_some());
            let same_drives = drive_kind(a) == drive_kind(b);
            if !same_drives && commands != (true, true) {
                both(a.id.drive_column(), a.drive.is_some(), a.drive.is_none())?;
            }
            if same_drives && a.drive.is_none() {
                both(a.id.command_column(), commands.0, commands.1)?;
            }
        }
        Ok(())
    }
}

/// Drives of a channel that the other recording does not have, or not of this kind.
fn leave_out_half_drives(first: &mut Recording, second: &mut Recording) {
    for (a, b) in first.channels.iter_mut().zip(&mut second.channels) {
        if drive_kind(a) != drive_kind(b) {
            (a.drive, b.drive) = (None, None);
        }
        // A command beside a drive is not simulated from: it may be in one file only.
        if a.command_kpa.is_some() != b.command_kpa.is_some() {
            (a.command_kpa, b.command_kpa) = (None, None);
        }
    }
}

fn drive_kind(channel: &Channel) -> Option<std::mem::Discriminant<Drive>> {
    channel.drive.as_ref().map(std::mem::discriminant)
}

fn append(column: &mut Option<Vec<f32>>, more: Option<Vec<f32>>) {
    if let (Some(column), Some(more)) = (column, more) {
        column.extend(more);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LoadOptions, read};

    fn recording(file: &str, drive: bool) -> Recording {
        let header = if drive { "t_s,b0_cmd0_kpa,b0_p0_kpa,b0_u0" } else { "t_s,b0_cmd0_kpa,b0_p0_kpa" };
        let row = |k: u32| format!("{:.2},100,{k}{}\n", 0.01 * f64::from(k), if drive { ",0.5" } else { "" });
        let text = format!("{header}\n{}", (0..50).map(row).collect::<String>());
        read(file, text.as_bytes(), LoadOptions::default()).expect("a whole recording").recording
    }

    #[test]
    fn where_only_some_have_drives_it_is_said_and_none_are_kept() {
        let (with, without) = (recording("with.csv", true), recording("without.csv", false));
        let said = "with.csv has drives, and without.csv has none";
        for pair in [[with.clone(), without.clone()], [without.clone(), with.clone()]] {
            assert!(half_drives(&pair).is_some_and(|sentence| sentence.starts_with(said)));
        }
        assert_eq!(half_drives(&[with.clone(), with.clone()]), None);
        let joined = with.followed_by(without).expect("both have commands");
        assert!(joined.channels.iter().all(|channel| channel.drive.is_none()));
    }
}
