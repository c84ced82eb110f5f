//! Messages to rows: one row for each cycle of the bus.

use std::collections::BTreeMap;

use super::Value;
use crate::column::ColumnKind;
use crate::csv::{Cell, RawColumn, RawTable, check_present};
use crate::{ChannelId, DataError};

/// What a message on a command topic asked for.
pub(super) struct Command {
    /// When it was recorded, ns.
    pub(super) log_ns: u64,
    pub(super) values: Vec<Value>,
}

/// What a board measured.
struct State {
    stamp_ns: u64,
    log_ns: u64,
    joint: u8,
    values: Vec<Value>,
}

/// All states of the boards on one bus.
#[derive(Default)]
pub(super) struct Bus {
    states: Vec<State>,
    joints: Vec<u8>,
}

impl Bus {
    pub(super) fn push(&mut self, stamp_ns: u64, log_ns: u64, joint: u8, values: Vec<Value>) {
        if !self.joints.contains(&joint) {
            self.joints.push(joint);
            self.joints.sort_unstable();
        }
        self.states.push(State { stamp_ns, log_ns, joint, values });
    }

    /// Numbers of the boards, ascending: the order in which they are asked.
    pub(super) fn joints(&self) -> &[u8] {
        &self.joints
    }

    /// Gives the states of `joint` that do not say what was commanded the command recorded last
    /// before them. `commands` are in the order of time. Commands that are no pressures were
    /// refused and did not change what was commanded.
    pub(super) fn complete(&mut self, joint: u8, commands: &[Command]) {
        let valid: Vec<_> =
            commands.iter().filter(|command| command.values.iter().all(|(_, kpa)| kpa.is_finite())).collect();
        for state in self.states.iter_mut().filter(|state| state.joint == joint) {
            let told = |(kind, _): &Value| matches!(kind, ColumnKind::Command(_));
            if state.values.iter().any(told) {
                continue;
            }
            let before = valid.partition_point(|command| command.log_ns <= state.log_ns);
            if let Some(command) = before.checked_sub(1).map(|last| valid[last]) {
                state.values.extend(command.values.iter().copied().filter(told));
            }
        }
    }

    /// One row for each cycle. Boards are asked in the order of their numbers, and none twice in a
    /// cycle: a row ends where a board comes that is not behind the one before it, or so late that
    /// it must be of the next cycle. Our own recordings give all states of a cycle one log time;
    /// others have the time at which each was received.
    pub(super) fn into_table(
        mut self,
        file: &str,
        channels: Option<&[ChannelId]>,
    ) -> Result<RawTable, DataError> {
        self.states.sort_by_key(|state| state.stamp_ns);
        let longest_ns = self.period_ns().saturating_mul(9) / 10;
        let mut table = Table::new(self.states.first().map_or(0, |state| state.stamp_ns));
        let mut row: Option<(&State, &State)> = None;
        for state in &self.states {
            let first = row.filter(|(first, last)| {
                let in_time = state.stamp_ns - first.stamp_ns < longest_ns || state.log_ns == first.log_ns;
                last.joint < state.joint && in_time
            });
            if first.is_none() {
                table.begin(state.stamp_ns);
            }
            row = Some((first.map_or(state, |(first, _)| first), state));
            for &(kind, value) in &state.values {
                table.put(file, kind, value)?;
            }
        }
        table.finish(file, channels)
    }

    /// Time between two states of a board, ns: the lower quartile, because states are left out but
    /// never added.
    fn period_ns(&self) -> u64 {
        let mut before: BTreeMap<u8, u64> = BTreeMap::new();
        let mut steps = Vec::new();
        for state in &self.states {
            if let Some(earlier) = before.insert(state.joint, state.stamp_ns) {
                steps.push(state.stamp_ns - earlier);
            }
        }
        let quarter = steps.len() / 4;
        if steps.is_empty() { u64::MAX } else { *steps.select_nth_unstable(quarter).1 }
    }
}

/// Columns that grow row by row.
struct Table {
    start_ns: u64,
    time_s: Vec<f64>,
    columns: BTreeMap<ColumnKind, Vec<f32>>,
}

impl Table {
    fn new(start_ns: u64) -> Self {
        Self { start_ns, time_s: Vec::new(), columns: BTreeMap::new() }
    }

    fn begin(&mut self, stamp_ns: u64) {
        self.time_s.push((stamp_ns - self.start_ns) as f64 * 1e-9);
    }

    /// Puts `value` into the row begun last.
    fn put(&mut self, file: &str, kind: ColumnKind, value: f64) -> Result<(), DataError> {
        let row = self.time_s.len();
        let value = if value.is_finite() { value } else { f64::NAN };
        Cell { file, line: row as u64 }.check_range(&kind.name(), kind, value)?;
        let column = self.columns.entry(kind).or_default();
        column.resize(row, f32::NAN);
        // Single precision: see RawTable.
        column[row - 1] = value as f32;
        Ok(())
    }

    fn finish(self, file: &str, channels: Option<&[ChannelId]>) -> Result<RawTable, DataError> {
        let rows = self.time_s.len();
        let names: Vec<_> = self.columns.keys().map(|kind| kind.name()).collect();
        for id in channels.unwrap_or_default() {
            check_present(file, *id, &names)?;
        }
        let wanted = |kind: ColumnKind| match (kind.channel(), channels) {
            (Some(id), Some(chosen)) => chosen.contains(&id),
            _ => kind != ColumnKind::Time,
        };
        let columns = self.columns.into_iter().filter(|(kind, _)| wanted(*kind)).map(|(kind, mut values)| {
            values.resize(rows, f32::NAN);
            RawColumn { kind, name: kind.name(), values }
        });
        Ok(RawTable {
            columns: columns.collect(),
            line: (0..rows).map(|row| u32::try_from(row + 1).unwrap_or(u32::MAX)).collect(),
            time_s: self.time_s,
            timeless_lines: Vec::new(),
            cut_off_line: None,
            near_misses: Vec::new(),
            unfinished: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressure(board: u8) -> ColumnKind {
        ColumnKind::Pressure(ChannelId { board, channel: 0 })
    }

    fn bus(states: &[(u64, u8)]) -> Bus {
        let mut bus = Bus::default();
        for &(stamp_us, joint) in states {
            bus.push(1_000 * stamp_us, 1_000 * stamp_us, joint, vec![(pressure(joint), stamp_us as f64)]);
        }
        bus
    }

    /// Times in us of the rows, and the stamps in them by board.
    fn rows(bus: Bus) -> Vec<(u64, [Option<f32>; 2])> {
        let table = bus.into_table("run.mcap", None).unwrap();
        let cell = |board: u8, row: usize| {
            let column = table.columns.iter().find(|column| column.kind == pressure(board))?;
            Some(column.values[row]).filter(|value| !value.is_nan())
        };
        let times = table.time_s.iter().map(|t| (t * 1e6).round() as u64);
        times.enumerate().map(|(row, t)| (t, [cell(0, row), cell(1, row)])).collect()
    }

    #[test]
    fn a_cycle_is_a_row() {
        let found = rows(bus(&[(100, 0), (600, 1), (1100, 0), (1600, 1)]));
        assert_eq!(found, [(0, [Some(100.0), Some(600.0)]), (1000, [Some(1100.0), Some(1600.0)])]);
    }

    #[test]
    fn a_board_left_out_leaves_a_hole() {
        // Board 0 is missing in the second cycle, board 1 in the third, then board 0 in the fourth.
        let cycles = [(0, 0), (500, 1), (1500, 1), (2000, 0), (3500, 1), (4000, 0), (4500, 1)];
        let found = rows(bus(&cycles));
        let expected = [
            (0, [Some(0.0), Some(500.0)]),
            (1500, [None, Some(1500.0)]),
            (2000, [Some(2000.0), None]),
            (3500, [None, Some(3500.0)]),
            (4000, [Some(4000.0), Some(4500.0)]),
        ];
        assert_eq!(found, expected);
    }

    /// One late exchange in a recording of our own: the log time tells that it is the same cycle.
    #[test]
    fn a_common_log_time_is_a_cycle() {
        let mut bus = bus(&[(0, 0), (500, 1), (1000, 0)]);
        bus.push(2_900_000, 1_000_000, 1, vec![(pressure(1), 2900.0)]);
        bus.push(3_000_000, 3_000_000, 0, vec![(pressure(0), 3000.0)]);
        let expected = [
            (0, [Some(0.0), Some(500.0)]),
            (1000, [Some(1000.0), Some(2900.0)]),
            (3000, [Some(3000.0), None]),
        ];
        assert_eq!(rows(bus), expected);
    }

    #[test]
    fn commands_are_held_where_states_do_not_tell() {
        let command = |log_us: u64, kpa: f64| Command {
            log_ns: 1_000 * log_us,
            values: vec![(ColumnKind::Command(ChannelId { board: 0, channel: 0 }), kpa)],
        };
        let mut bus = bus(&[(0, 0), (1000, 0), (2000, 0), (3000, 0)]);
        bus.complete(0, &[command(500, 10.0), command(1500, f64::NAN), (command(2500, 20.0))]);
        let table = bus.into_table("run.mcap", None).unwrap();
        let commands = table.columns.iter().find(|column| matches!(column.kind, ColumnKind::Command(_)));
        let values = &commands.unwrap().values;
        assert!(values[0].is_nan());
        assert_eq!(values[1..], [10.0, 10.0, 20.0]);
    }
}
