//! From a file to a checked recording.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::column::ColumnKind;
use super::csv::{RawColumn, RawTable, ReadPlan};
use super::quality::{self, FindingKind, QualityReport, SensorLimits};
use super::{
    BoardSupply, Channel, ChannelId, DataError, Drive, Finding, Flags, Joint, Recording, bag, csv, source,
    sparse,
};

/// From a sample in 30,000 years (or one in ten seconds, in nanoseconds that were taken for
/// seconds) to the resolution of a time stamp in picoseconds.
const POSSIBLE_RATES_HZ: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

/// The limits of a channel's pressure sensor, where they are known.
pub type LimitsOf<'a> = &'a dyn Fn(ChannelId) -> Option<SensorLimits>;

/// What to read and against what to check it.
#[derive(Default)]
pub struct LoadOptions<'a> {
    /// Channels to keep; `None` keeps all.
    pub channels: Option<&'a [ChannelId]>,
    /// The limits of each channel's pressure sensor, from the rig file (`Rig::sensor_limits`);
    /// where there are none, no sample counts as saturated.
    pub limits: Option<LimitsOf<'a>>,
    /// Pressure of the supply in the rig file, kPa gauge: pressures that do not go with it are
    /// remarked upon.
    pub supply_kpa: Option<f64>,
    /// Told now and then: stored bytes read so far and in all.
    pub progress: Option<&'a mut dyn FnMut(u64, u64)>,
}

/// A recording and what was found in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Loaded {
    /// The data, doubtful samples masked.
    pub recording: Recording,
    /// What was masked and why.
    pub quality: QualityReport,
}

/// Reads, checks and masks the recording at `path`.
///
/// # Errors
/// [`DataError`] when the file cannot be read or understood, naming file, row and column. Defects
/// that masking deals with are no errors: see [`QualityReport`].
pub fn load(path: &Path, options: LoadOptions<'_>) -> Result<Loaded, DataError> {
    let mut open = source::open(path)?;
    let meter = open.meter();
    let size = open.size;
    let mut listener = options.progress;
    let mut progress = |_rows: usize| {
        if let Some(told) = listener.as_mut() {
            told(meter.bytes(), size);
        }
    };
    let mut plan = ReadPlan { channels: options.channels, progress: &mut progress };
    let file = open.file.clone();
    let table = if open.is_bag {
        bag::read(&file, size, &mut *open.text, &mut plan)?
    } else {
        csv::read(&file, &mut *open.text, &mut plan)?
    };
    let source = open.finish()?;
    assemble(table, source, options.limits, options.supply_kpa)
}

/// Checks and masks a recording that is in memory already, as the content of a CSV file called
/// `file` in messages.
///
/// # Errors
/// As [`load`].
pub fn read(file: &str, text: &[u8], options: LoadOptions<'_>) -> Result<Loaded, DataError> {
    let mut plan = ReadPlan { channels: options.channels, progress: &mut |_| {} };
    let table = csv::read(file, &mut &*text, &mut plan)?;
    assemble(table, source::of_bytes(file, text), options.limits, options.supply_kpa)
}

/// Checks the raw columns and sorts them into channels.
fn assemble(
    mut table: RawTable,
    source: super::Source,
    limits: Option<LimitsOf<'_>>,
    supply_kpa: Option<f64>,
) -> Result<Loaded, DataError> {
    let rows_read =
        table.time_s.len() + table.timeless_lines.len() + usize::from(table.cut_off_line.is_some());
    let mut findings = header_findings(&table);
    if let Some((keep, finding)) = quality::keep_increasing(&table.time_s, &table.line) {
        findings.push(finding);
        table.retain(&keep);
    }
    let rows = table.time_s.len();
    if rows < 2 {
        let why = findings.iter().map(|finding| format!(" {}", finding.sentence)).collect();
        return Err(DataError::TooFewRows { file: source.file, rows, why });
    }
    let sampling = quality::sampling(&table.time_s);
    if !POSSIBLE_RATES_HZ.contains(&sampling.rate_hz) {
        return Err(DataError::ImpossibleRate { file: source.file, rate_hz: sampling.rate_hz });
    }
    // A file of commands was not sampled: each row holds until the next, however long that is.
    let commands_alone = table.columns.iter().all(|column| matches!(column.kind, ColumnKind::Command(_)));
    let mut breaks = Vec::new();
    if !commands_alone {
        let (found, gaps) = quality::find_breaks(&table.time_s, &table.line, &sampling);
        breaks = found;
        findings.extend(gaps);
    }

    let (time_s, line) = (table.time_s, table.line);
    let mut columns =
        Columns { columns: table.columns, time_s: &time_s, line: &line, findings: &mut findings };
    // An input all channels share: where it is missing, it is missing for all.
    let supply = columns.take_input(ColumnKind::Supply);
    let supplies = columns.take_board_supplies();
    let mut boards: Vec<u8> = columns
        .columns
        .iter()
        .filter_map(|c| match c.kind {
            ColumnKind::JointU(board) | ColumnKind::JointV(board) => Some(board),
            _ => None,
        })
        .collect();
    boards.sort_unstable();
    boards.dedup();
    let mut joints = Vec::new();
    let mut joint_marks = Vec::new();
    for board in boards {
        let u = columns.take_input(ColumnKind::JointU(board));
        let v = columns.take_input(ColumnKind::JointV(board));
        joint_marks.push((board, u.marks, v.marks));
        joints.push(Joint { board, qu_rad: u.values, qv_rad: v.values });
    }
    let mut ids: Vec<ChannelId> = columns.columns.iter().filter_map(|c| c.kind.channel()).collect();
    ids.sort_unstable();
    ids.dedup();
    let mut channels = Vec::with_capacity(ids.len());
    for id in ids {
        let mut flags = vec![Flags::NONE; rows];
        // A board that measures its supply does not need the rig's.
        match supplies.iter().find(|(own, _)| own.board == id.board) {
            Some((_, marks)) => merge(&mut flags, marks.as_deref()),
            None => merge(&mut flags, supply.marks.as_deref()),
        }
        if let Some((_, u, v)) = joint_marks.iter().find(|(board, _, _)| *board == id.board) {
            merge(&mut flags, if id.channel < 2 { u.as_deref() } else { v.as_deref() });
        }
        channels.push(columns.channel(id, &source.file, limits.and_then(|of| of(id)).as_ref(), flags)?);
    }
    findings.extend(supply_kpa.and_then(|kpa| quality::odd_pressure(&channels, kpa)));
    let period_s = sampling.rate_hz.recip();
    let board_supplies = supplies.into_iter().map(|(own, _)| own).collect();
    let supply_kpa = supply.values;
    let recording =
        Recording { source, time_s, line, breaks, period_s, channels, joints, supply_kpa, board_supplies };
    let quality = QualityReport { rows_read, rows_kept: rows, sampling, findings };
    Ok(Loaded { recording, quality })
}

fn header_findings(table: &RawTable) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (found, meant) in &table.near_misses {
        let sentence = format!(
            "Column {found} is not used: the format knows {meant}. Rename it if that is what it is, or convert its unit with `pneudrive-model import --map`."
        );
        findings.push(Finding::new(FindingKind::UnusedColumn, None, 1, Vec::new(), sentence));
    }
    if let Some(row) = table.cut_off_line {
        let sentence = format!("The last row ({row}) stops in the middle and is left out.");
        findings.push(Finding::new(FindingKind::CutOffRow, None, 1, Vec::new(), sentence));
    }
    if let Some(reason) = &table.unfinished {
        let sentence = format!(
            "The end of the file is missing ({reason}), as when its recorder was killed: read as far as it goes."
        );
        findings.push(Finding::new(FindingKind::CutOffRow, None, 1, Vec::new(), sentence));
    }
    if let (Some(first), count) = (table.timeless_lines.first(), table.timeless_lines.len()) {
        let sentence = format!(
            "t_s is empty or no usable number in {count} row(s), the first of them row {first}: left out."
        );
        findings.push(Finding::new(FindingKind::MissingTime, None, count, Vec::new(), sentence));
    }
    findings
}

fn merge(flags: &mut [Flags], marks: Option<&[Flags]>) {
    for (flag, mark) in flags.iter_mut().zip(marks.unwrap_or_default()) {
        flag.insert(*mark);
    }
}

impl RawTable {
    fn retain(&mut self, keep: &[bool]) {
        fn filter<T>(values: &mut Vec<T>, keep: &[bool]) {
            let mut verdict = keep.iter();
            values.retain(|_| verdict.next().copied().unwrap_or(false));
        }
        filter(&mut self.time_s, keep);
        filter(&mut self.line, keep);
        for column in &mut self.columns {
            filter(&mut column.values, keep);
        }
    }
}

/// An input column after its missing cells were dealt with.
struct Input {
    values: Option<Vec<f32>>,
    marks: Option<Vec<Flags>>,
}

/// The columns not yet given away.
struct Columns<'a> {
    columns: Vec<RawColumn>,
    time_s: &'a [f64],
    line: &'a [u32],
    findings: &'a mut Vec<Finding>,
}

impl Columns<'_> {
    fn take(&mut self, kind: ColumnKind) -> Option<RawColumn> {
        let index = self.columns.iter().position(|c| c.kind == kind)?;
        Some(self.columns.swap_remove(index))
    }

    fn take_input(&mut self, kind: ColumnKind) -> Input {
        let Some(mut column) = self.take(kind) else { return Input { values: None, marks: None } };
        let held =
            quality::hold_inputs(&column.name, kind.channel(), self.time_s, self.line, &mut column.values);
        let marks = held.map(|(marks, finding)| {
            self.findings.push(finding);
            marks
        });
        Input { values: Some(column.values), marks }
    }

    /// What boards measure themselves, now and then; without those that have no such sensor.
    fn take_board_supplies(&mut self) -> Vec<(BoardSupply, Option<Vec<Flags>>)> {
        let board = |column: &RawColumn| match column.kind {
            ColumnKind::BoardSupply(board) => Some(board),
            _ => None,
        };
        let mut boards: Vec<u8> = self.columns.iter().filter_map(board).collect();
        boards.sort_unstable();
        let mut supplies = Vec::new();
        for board in boards {
            let Some(mut column) = self.take(ColumnKind::BoardSupply(board)) else { continue };
            if column.values.iter().all(|value| value.is_nan()) {
                continue;
            }
            let marks = sparse::fill(self.time_s, &mut column.values);
            self.findings.extend(quality::missing_for_long(
                &column.name,
                self.time_s,
                self.line,
                &column.values,
            ));
            supplies.push((BoardSupply { board, kpa: column.values }, marks));
        }
        supplies
    }

    fn channel(
        &mut self,
        id: ChannelId,
        file: &str,
        limits: Option<&SensorLimits>,
        mut flags: Vec<Flags>,
    ) -> Result<Channel, DataError> {
        let drive = self.drive(id, file, &mut flags)?;
        let command = self.take_input(ColumnKind::Command(id));
        // The command of a channel whose drive is recorded is not simulated from.
        if drive.is_none() {
            merge(&mut flags, command.marks.as_deref());
        }
        let pressure = self.take(ColumnKind::Pressure(id)).map(|c| c.values);
        if let Some(values) = &pressure {
            let (time_s, line) = (self.time_s, self.line);
            self.findings.extend(quality::mark_missing_pressure(id, time_s, line, values, &mut flags));
            if let Some(limits) = limits {
                self.findings.extend(quality::mark_saturated(id, time_s, line, values, limits, &mut flags));
            }
            let told = quality::Told { command_kpa: command.values.as_deref(), drive: drive.as_ref() };
            self.findings.extend(quality::mark_stuck(id, time_s, line, values, &told, &mut flags));
        }
        Ok(Channel { id, command_kpa: command.values, pressure_kpa: pressure, drive, flags })
    }

    fn drive(&mut self, id: ChannelId, file: &str, flags: &mut [Flags]) -> Result<Option<Drive>, DataError> {
        let spool = self.take_input(ColumnKind::Spool(id));
        let fill = self.take_input(ColumnKind::Fill(id));
        let vent = self.take_input(ColumnKind::Vent(id));
        for marks in [&spool.marks, &fill.marks, &vent.marks] {
            merge(flags, marks.as_deref());
        }
        let (fill_name, vent_name) = id.fill_vent_columns();
        let half = |present: String, missing: String| DataError::HalfDrive {
            file: file.to_owned(),
            present,
            missing,
        };
        match (spool.values, fill.values, vent.values) {
            (None, None, None) => Ok(None),
            (Some(u), None, None) => Ok(Some(Drive::Spool(u))),
            (None, Some(fill), Some(vent)) => Ok(Some(Drive::Separate { fill, vent })),
            (_, Some(_), None) => Err(half(fill_name, vent_name)),
            (_, None, Some(_)) => Err(half(vent_name, fill_name)),
            (Some(_), Some(_), Some(_)) => Err(DataError::TwoDrives {
                file: file.to_owned(),
                channel: id,
                spool: id.drive_column(),
                fill: fill_name,
            }),
        }
    }
}
