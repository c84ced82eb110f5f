//! Rows of a table or of a finished recording, as a watcher takes them.

use super::sample::{Columns, Reading, Sample};
use crate::data::ColumnKind;
use crate::data::{ChannelId, DataError, Drive, LiveTable, Recording};

/// The rows of a table, as they come.
pub struct Rows {
    table: LiveTable,
    columns: Vec<Columns>,
    /// Of each number of a row: where it belongs.
    places: Vec<Place>,
    values: Vec<f64>,
}

#[derive(Clone, Copy)]
enum Place {
    Time,
    Supply,
    Unused,
    Pressure(usize),
    Command(usize),
    Drive(usize),
    Vent(usize),
    /// The angle of a board's joint, of the channels from this number on.
    Joint(u8, u8),
}

impl Rows {
    /// Of a table.
    #[must_use]
    pub fn new(table: LiveTable) -> Self {
        let kinds: Vec<ColumnKind> = table.kinds().collect();
        let mut ids: Vec<ChannelId> = kinds.iter().filter_map(|kind| kind.channel()).collect();
        ids.sort_unstable();
        ids.dedup();
        let has = |kind: ColumnKind| kinds.contains(&kind);
        let columns: Vec<Columns> = ids
            .iter()
            .map(|&id| Columns {
                id,
                command: has(ColumnKind::Command(id)),
                spool: has(ColumnKind::Spool(id)),
                separate: has(ColumnKind::Fill(id)) && has(ColumnKind::Vent(id)),
                angle: match id.channel {
                    0 | 1 => has(ColumnKind::JointU(id.board)),
                    2 | 3 => has(ColumnKind::JointV(id.board)),
                    _ => false,
                },
            })
            .collect();
        let measuring = |kind: &ColumnKind| match kind {
            ColumnKind::BoardSupply(board) => Some(*board),
            _ => None,
        };
        let first_measuring = kinds.iter().filter_map(measuring).min();
        let at = |id: &ChannelId| ids.partition_point(|known| known < id);
        let place = |kind: &ColumnKind| match kind {
            ColumnKind::Time => Place::Time,
            ColumnKind::Supply => Place::Supply,
            // One supply for all: that of the first board that measures it, where the rig's is not
            // recorded.
            ColumnKind::BoardSupply(board) if !has(ColumnKind::Supply) && first_measuring == Some(*board) => {
                Place::Supply
            }
            ColumnKind::BoardSupply(_) => Place::Unused,
            ColumnKind::Pressure(id) => Place::Pressure(at(id)),
            ColumnKind::Command(id) => Place::Command(at(id)),
            ColumnKind::Spool(id) | ColumnKind::Fill(id) => Place::Drive(at(id)),
            ColumnKind::Vent(id) => Place::Vent(at(id)),
            ColumnKind::JointU(board) => Place::Joint(*board, 0),
            ColumnKind::JointV(board) => Place::Joint(*board, 2),
        };
        let places = kinds.iter().map(place).collect();
        Self { table, columns, places, values: Vec::new() }
    }

    /// What there is of each channel.
    #[must_use]
    pub fn columns(&self) -> &[Columns] {
        &self.columns
    }

    /// The next row, or none at the end.
    ///
    /// # Errors
    /// [`DataError`] naming the line.
    pub fn next_row(&mut self) -> Result<Option<Sample>, DataError> {
        if !self.table.next(&mut self.values)? {
            return Ok(None);
        }
        let mut row =
            Sample { t_s: 0.0, supply_kpa: f64::NAN, channels: vec![Reading::default(); self.columns.len()] };
        for (place, value) in self.places.iter().zip(&self.values) {
            match *place {
                Place::Time => row.t_s = *value,
                Place::Supply => row.supply_kpa = *value,
                Place::Unused => {}
                Place::Pressure(k) => row.channels[k].pressure_kpa = *value,
                Place::Command(k) => row.channels[k].command_kpa = *value,
                Place::Drive(k) => row.channels[k].drive = *value,
                Place::Vent(k) => row.channels[k].vent = *value,
                Place::Joint(board, first) => {
                    for (one, reading) in self.columns.iter().zip(&mut row.channels) {
                        if one.id.board == board && (first..first + 2).contains(&one.id.channel) {
                            reading.angle_rad = *value;
                        }
                    }
                }
            }
        }
        Ok(Some(row))
    }
}

/// What a finished recording has of each channel.
#[must_use]
pub fn columns_of(recording: &Recording) -> Vec<Columns> {
    let one = |channel: &crate::data::Channel| Columns {
        id: channel.id,
        command: channel.command_kpa.is_some(),
        spool: matches!(channel.drive, Some(Drive::Spool(_))),
        separate: matches!(channel.drive, Some(Drive::Separate { .. })),
        angle: recording.joint_angle(channel.id).is_some(),
    };
    recording.channels.iter().map(one).collect()
}

/// The rows of a finished recording.
pub fn samples_of(recording: &Recording) -> impl Iterator<Item = Sample> + '_ {
    let at = |column: Option<&[f32]>, row: usize| column.map_or(f64::NAN, |values| f64::from(values[row]));
    let own = recording.board_supplies.first().map(|own| own.kpa.as_slice());
    let supply = recording.supply_kpa.as_deref().or(own);
    (0..recording.rows()).map(move |row| {
        let reading = |channel: &crate::data::Channel| {
            let (drive, vent) = match &channel.drive {
                Some(Drive::Spool(u)) => (Some(&u[..]), None),
                Some(Drive::Separate { fill, vent }) => (Some(&fill[..]), Some(&vent[..])),
                None => (None, None),
            };
            Reading {
                pressure_kpa: at(channel.pressure_kpa.as_deref(), row),
                command_kpa: at(channel.command_kpa.as_deref(), row),
                drive: at(drive, row),
                vent: at(vent, row),
                angle_rad: at(recording.joint_angle(channel.id).map(|(angle, _)| angle), row),
            }
        };
        Sample {
            t_s: recording.time_s[row],
            supply_kpa: at(supply, row),
            channels: recording.channels.iter().map(reading).collect(),
        }
    })
}
