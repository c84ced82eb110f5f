use super::{Channel, ColumnName, Trajectory, TrajectoryError};
use crate::stored::Stored;
use csv::StringRecord;
use pneudrive_host::Calibration;
use pneudrive_protocol::CHANNELS;
use std::io::Read;
use std::path::Path;

/// Longest time accepted, s: 30 years, far below what u64 ns hold.
const LATEST_S: f64 = 1e9;

/// A command column: its place in the row and what it is for.
struct Column {
    place: usize,
    name: String,
    channel: Channel,
}

impl Trajectory {
    /// Reads and checks a file for `boards` boards, numbered from 0: CSV, also compressed (gzip,
    /// zstd), or a ROS 2 bag. What it is its first bytes say.
    ///
    /// # Errors
    /// The first thing that is wrong with it, by file, row and column.
    pub fn read(
        path: &Path,
        boards: usize,
        calibration: impl Into<Calibration>,
    ) -> Result<Self, TrajectoryError> {
        let file = path.display().to_string();
        let opened = Stored::open(path)
            .map_err(|error| TrajectoryError::Unreadable { file: file.clone(), reason: error.to_string() })?;
        match opened {
            Stored::Text(text) => Self::parse(&file, text, boards, calibration),
            Stored::Bag(content) => super::bag::read(&file, content, boards, &calibration.into()),
        }
    }

    /// Like [`read`](Self::read), from anything that gives CSV; `file` is the name for errors.
    ///
    /// # Errors
    /// As for [`read`](Self::read).
    pub fn parse(
        file: &str,
        from: impl Read,
        boards: usize,
        calibration: impl Into<Calibration>,
    ) -> Result<Self, TrajectoryError> {
        let calibration = calibration.into();
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            // What a recording says of itself, and its events.
            .comment(Some(b'#'))
            .from_reader(from);
        let header = reader.headers().map_err(|error| not_csv(file, &error))?.clone();
        let header_row = line_of(&header, reader.position());
        let Header { time, mut columns, ignored } = Header::understand(file, header_row, &header, boards)?;
        let mut times_ns = Vec::new();
        let mut last_s = None;
        let mut record = StringRecord::new();
        while reader.read_record(&mut record).map_err(|error| not_csv(file, &error))? {
            let row = line_of(&record, reader.position());
            let time_s = number(file, &record, row, time, "t_s")?;
            let later = last_s.is_none_or(|last| time_s > last);
            if !(later && (0.0..=LATEST_S).contains(&time_s)) {
                return Err(TrajectoryError::Time { file: file.to_owned(), row, time_s });
            }
            last_s = Some(time_s);
            times_ns.push((time_s * 1e9).round() as u64);
            for Column { place, name, channel } in &mut columns {
                let kpa = number(file, &record, row, *place, name)?;
                channel.scale(&calibration).counts(kpa).map_err(|reason| TrajectoryError::Pressure {
                    file: file.to_owned(),
                    row,
                    column: name.clone(),
                    reason,
                })?;
                channel.kpa.push(kpa);
            }
        }
        if times_ns.is_empty() {
            return Err(TrajectoryError::NoRows { file: file.to_owned() });
        }
        // Times closer than 1 ns would be one time.
        times_ns.dedup();
        if times_ns.len() != columns[0].channel.kpa.len() {
            return Err(TrajectoryError::Time {
                file: file.to_owned(),
                row: 0,
                time_s: last_s.unwrap_or(0.0),
            });
        }
        let channels = columns.into_iter().map(|column| column.channel).collect();
        Ok(Self { times_ns, channels, ignored })
    }
}

/// The line of a record that ends before `after`. The reader takes comments above it for a part of
/// it.
fn line_of(record: &StringRecord, after: &csv::Position) -> u64 {
    record.position().map_or(1, csv::Position::line).max(after.line().saturating_sub(1))
}

/// What the columns are.
struct Header {
    /// Place of the time column.
    time: usize,
    columns: Vec<Column>,
    /// Names that say nothing to a trajectory, and that no recording has.
    ignored: Vec<String>,
}

impl Header {
    fn understand(
        file: &str,
        row: u64,
        header: &StringRecord,
        boards: usize,
    ) -> Result<Self, TrajectoryError> {
        let mut time = None;
        let mut columns: Vec<Column> = Vec::new();
        let mut ignored = Vec::new();
        for (place, name) in header.iter().enumerate() {
            let file = file.to_owned();
            let name = name.trim_start_matches('\u{feff}').to_owned();
            match ColumnName::of(&name) {
                ColumnName::Time => {
                    if time.replace(place).is_some() {
                        return Err(TrajectoryError::DuplicateColumn { file, row, column: name });
                    }
                }
                ColumnName::Command { board, channel } => {
                    if board >= boards || channel >= CHANNELS {
                        let row = Some(row);
                        return Err(TrajectoryError::NoSuchChannel { file, row, column: name, boards });
                    }
                    let is_same =
                        |other: &Column| (other.channel.board, other.channel.channel) == (board, channel);
                    if columns.iter().any(is_same) {
                        return Err(TrajectoryError::DuplicateColumn { file, row, column: name });
                    }
                    columns.push(Column {
                        place,
                        name,
                        channel: Channel { board, channel, kpa: Vec::new() },
                    });
                }
                ColumnName::Misspelt { meant } => {
                    return Err(TrajectoryError::UnknownCommand {
                        file,
                        row: Some(row),
                        column: name,
                        meant,
                    });
                }
                ColumnName::Recorded => {}
                // Spreadsheets end lines with a comma.
                ColumnName::Other if name.is_empty() => {}
                ColumnName::Other => ignored.push(name),
            }
        }
        let missing = |expected| TrajectoryError::MissingColumn { file: file.to_owned(), row, expected };
        if columns.is_empty() {
            return Err(missing("b{n}_cmd{k}_kpa"));
        }
        Ok(Self { time: time.ok_or_else(|| missing("t_s"))?, columns, ignored })
    }
}

fn number(
    file: &str,
    record: &StringRecord,
    row: u64,
    place: usize,
    column: &str,
) -> Result<f64, TrajectoryError> {
    let text = record.get(place).unwrap_or_default();
    text.parse().map_err(|_| TrajectoryError::NotANumber {
        file: file.to_owned(),
        row,
        column: column.to_owned(),
        text: text.to_owned(),
    })
}

fn not_csv(file: &str, error: &csv::Error) -> TrajectoryError {
    let row = error.position().map_or(1, csv::Position::line);
    let reason = match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("expected {expected_len} cells as in the header, found {len}")
        }
        csv::ErrorKind::Utf8 { .. } => "not text in UTF-8".to_owned(),
        csv::ErrorKind::Io(error) => error.to_string(),
        _ => error.to_string(),
    };
    TrajectoryError::NotCsv { file: file.to_owned(), row, reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Trajectory, TrajectoryError> {
        Trajectory::parse("f.csv", text.as_bytes(), 2, Calibration::default())
    }

    #[track_caller]
    fn refused(text: &str, message: &str) {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }

    #[test]
    fn what_is_wrong_is_named_by_row_and_column() {
        refused("", "no column b{n}_cmd{k}_kpa");
        refused("t_s\n0\n", "no column b{n}_cmd{k}_kpa");
        refused("b0_cmd0_kpa\n0\n", "no column t_s");
        refused("t_s,b0_cmd0_kpa,b0_cmd0_kpa\n0,0,0\n", "column b0_cmd0_kpa is there twice");
        refused("t_s,b2_cmd0_kpa\n0,0\n", "column b2_cmd0_kpa: there are boards 0 to 1");
        refused("t_s,b1_cmd4_kpa\n0,0\n", "column b1_cmd4_kpa: there are boards 0 to 1");
        for misspelt in ["b0_cmd_kpa", "b0_cdm1_kpa", "b0_cmd1_bar", "b0_cmd_1_kpa", "B0_Cmd1_kPa"] {
            let said = format!("row 1: column {misspelt} is not one that a trajectory has");
            refused(&format!("t_s,b0_cmd0_kpa,{misspelt}\n0,0,0\n"), &said);
        }
        refused("t_s,b0_cdm0_kpa\n0,0\n", "a trajectory has; did you mean b0_cmd0_kpa? Rename it");
        refused("t_s,b0_cmd0_kpa\n", "no rows below the header");
        refused(
            "t_s,b0_cmd0_kpa\n0,1\n1,two\n",
            "row 3, column b0_cmd0_kpa: expected a number, found \"two\"",
        );
        refused("t_s,b0_cmd0_kpa\n0,\n", "row 2, column b0_cmd0_kpa: expected a number, found \"\"");
        refused("t_s,b0_cmd0_kpa\n0,1\n0,2\n", "row 3, column t_s: 0 s");
        refused("t_s,b0_cmd0_kpa\n-1,1\n", "row 2, column t_s: -1 s");
        refused("t_s,b0_cmd0_kpa\nNaN,1\n", "row 2, column t_s: NaN s");
        refused(
            "t_s,b0_cmd0_kpa\n0,776\n",
            "row 2, column b0_cmd0_kpa: commanded pressure is 776 kPa, above",
        );
        refused("t_s,b0_cmd0_kpa\n0,NaN\n", "row 2, column b0_cmd0_kpa: commanded pressure is NaN");
        refused("t_s,b0_cmd0_kpa\n0,-1\n", "row 2, column b0_cmd0_kpa: commanded pressure is -1 kPa");
        refused("t_s,b0_cmd0_kpa\n0,1\n1\n", "row 3: not readable as CSV: expected 2 cells");
    }

    #[test]
    fn spreadsheets_and_recordings_are_accepted() {
        let text = "\u{feff}t_s, b0_p0_kpa ,b1_cmd3_kpa\r\n0.5,,10\r\n0.75,3,20\r\n";
        let trajectory = parse(text).unwrap();
        assert_eq!((trajectory.rows(), trajectory.seconds()), (2, 0.75));
        let recording = "# port: \"x\"\n# boards: [0]\nt_s,b0_cmd0_kpa\n0,1\n# event: {\"t_s\":0.5}\n1,2\n";
        assert_eq!(parse(recording).unwrap().rows(), 2);
    }

    #[test]
    fn columns_of_others_are_ignored_and_named() {
        let trajectory = parse("t_s,b0_cmd0_kpa,note,b0_p0_kpa,bend\n0,1,a,2,\n").unwrap();
        assert_eq!(trajectory.ignored(), ["note", "bend"]);
    }

    #[test]
    fn rows_are_lines_of_the_file_comments_and_all() {
        refused("# a\n# b\nt_s,b2_cmd0_kpa\n0,0\n", "row 3, column b2_cmd0_kpa: there are boards");
        refused("# a\nt_s,b0_cmd0_kpa\n0,1\n# b\n0,2\n", "row 5, column t_s: 0 s");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "(t_s|b0_cmd[0-9]_kpa|[0-9.,eE\n\"-]){0,40}") {
            let _ = parse(&text);
        }
    }
}
