//! What a rig file says, in the words of those who use it.

use crate::read::{Content, Value, read};
use crate::{CHANNELS, RigError, Unit};
use std::collections::BTreeSet;
use std::path::Path;

/// A rig file that has been read and checked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rig {
    file: String,
    text: String,
    content: Content,
}

/// How the boards are reached, as far as the file says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bus {
    /// Serial port, or `sim`.
    pub port: Option<String>,
    /// Boards on the bus, numbered from 0: 1 to 256.
    pub boards: Option<u16>,
    /// Line rate, bit/s; `None` also where it is [found out](Self::baud_auto).
    pub baud: Option<u32>,
    /// The fastest line rate that all boards agree to.
    pub baud_auto: bool,
    /// Cycles per second, Hz, above 0.
    pub rate_hz: Option<f64>,
}

/// What may be commanded to a channel. `None` is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limit {
    /// Highest set point, kPa gauge, from 0 on.
    pub max_kpa: Option<f64>,
    /// Fastest change of a set point, kPa/s, above 0.
    pub max_rate_kpa_s: Option<f64>,
}

/// What a sensor's counts mean: kPa gauge = (counts - `zero_counts`) `kpa_per_count`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Reading at 0 kPa gauge, counts.
    pub zero_counts: f64,
    /// Pressure of one count, kPa.
    pub kpa_per_count: f64,
}

impl Limit {
    fn stricter(self, other: Self) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        Self {
            max_kpa: least(self.max_kpa, other.max_kpa),
            max_rate_kpa_s: least(self.max_rate_kpa_s, other.max_rate_kpa_s),
        }
    }
}

impl Rig {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or something in it cannot be used: with its line and what is
    /// expected.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|error| RigError::Open { file: file.clone(), error: unread(path, &error) })?;
        Self::parse(&file, &text)
    }

    /// The same from a text; `file` is its name in messages.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
    pub fn parse(file: &str, text: &str) -> Result<Self, RigError> {
        Ok(Self { file: file.to_owned(), text: text.to_owned(), content: read(file, text, None)? })
    }

    /// Checks a rig that stands in a table of another file, as a fit keeps the one that it was made
    /// with. Lines in messages are those of that file.
    ///
    /// # Errors
    /// As for [`load`](Self::load); also where there is no such table.
    pub fn check_table(file: &str, text: &str, table: &str) -> Result<(), RigError> {
        read(file, text, Some(table)).map(|_| ())
    }

    /// The file's name.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The file's text, for recordings to carry.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The number at a key with its table, such as `chamber.radius_m`.
    #[must_use]
    pub fn number(&self, path: &str) -> Option<f64> {
        match self.content.values.get(path)? {
            Value::Number(number) => Some(*number),
            Value::Text(_) => None,
        }
    }

    /// The words at a key with its table, such as `bus.port`.
    #[must_use]
    pub fn words(&self, path: &str) -> Option<&str> {
        match self.content.values.get(path)? {
            Value::Number(_) => None,
            Value::Text(text) => Some(text),
        }
    }

    /// The line of a table or key, counted from 1.
    #[must_use]
    pub fn line(&self, path: &str) -> Option<usize> {
        self.content.lines.get(path).copied()
    }

    /// How the boards are reached.
    #[must_use]
    pub fn bus(&self) -> Bus {
        Bus {
            port: self.words("bus.port").map(str::to_owned),
            // Whole numbers in these ranges, or the file would have been refused.
            boards: self.number("bus.boards").map(|boards| boards as u16),
            baud: self.number("bus.baud").map(|baud| baud as u32),
            baud_auto: self.words("bus.baud").is_some(),
            rate_hz: self.number("bus.rate_hz"),
        }
    }

    /// The unit in which people see pressures.
    #[must_use]
    pub fn unit(&self) -> Unit {
        self.words("display.unit").and_then(Unit::named).unwrap_or_default()
    }

    /// What people call a board.
    #[must_use]
    pub fn board_name(&self, board: u8) -> Option<&str> {
        self.words(&format!("boards.{board}.name"))
    }

    /// What people call a channel.
    #[must_use]
    pub fn channel_name(&self, board: u8, channel: usize) -> Option<&str> {
        self.words(&format!("boards.{board}.channels.{channel}.name"))
    }

    /// Boards that the file says something about.
    #[must_use]
    pub fn boards(&self) -> BTreeSet<u8> {
        let number = |path: &String| path.strip_prefix("boards.")?.split('.').next()?.parse().ok();
        self.content.lines.keys().filter_map(number).collect()
    }

    /// The strictest of the limits that apply to a channel.
    #[must_use]
    pub fn limit(&self, board: u8, channel: usize) -> Limit {
        let of = |place: &str| Limit {
            max_kpa: self.number(&format!("{place}limits.max_kpa")),
            max_rate_kpa_s: self.number(&format!("{place}limits.max_rate_kpa_s")),
        };
        let [all, of_board, own] = places(board, channel).map(|place| of(&place));
        own.stricter(of_board).stricter(all)
    }

    /// The limit of every channel of every board.
    #[must_use]
    pub fn usual_limit(&self) -> Limit {
        Limit { max_kpa: self.number("limits.max_kpa"), max_rate_kpa_s: self.number("limits.max_rate_kpa_s") }
    }

    /// The lowest of all highest set points, kPa gauge; none where no channel has a limit.
    #[must_use]
    pub fn lowest_max_kpa(&self) -> Option<f64> {
        let channels = self.boards().into_iter().flat_map(|board| (0..CHANNELS).map(move |c| (board, c)));
        let limits = channels.map(|(board, channel)| self.limit(board, channel));
        limits.fold(self.usual_limit(), Limit::stricter).max_kpa
    }

    /// The calibration of a channel: its own, else its board's, else that of all sensors.
    #[must_use]
    pub fn sensor(&self, board: u8, channel: usize) -> Option<Sensor> {
        let [all, of_board, own] = places(board, channel);
        [own, of_board, all].iter().find_map(|place| self.sensor_at(place))
    }

    /// The calibration of all sensors without their own.
    #[must_use]
    pub fn usual_sensor(&self) -> Option<Sensor> {
        self.sensor_at("")
    }

    /// The table that says what a channel's counts mean, and its line, for messages.
    #[must_use]
    pub fn sensor_place(&self, board: u8, channel: usize) -> Option<(String, usize)> {
        let [all, of_board, own] = places(board, channel);
        let mut tables = [own, of_board, all].into_iter().map(|place| format!("{place}sensor"));
        tables.find_map(|table| self.line(&table).map(|line| (table.clone(), line)))
    }

    /// Pressure of the air around the rig, kPa absolute, where the file says it.
    #[must_use]
    pub fn ambient_kpa(&self) -> Option<f64> {
        self.number("ambient.pressure_kpa_abs")
    }

    /// Resolution of the converters, bit, where the file says it.
    #[must_use]
    pub fn sensor_bits(&self) -> Option<u32> {
        self.number("sensor.bits").map(|bits| bits as u32)
    }

    fn sensor_at(&self, place: &str) -> Option<Sensor> {
        Some(Sensor {
            zero_counts: self.number(&format!("{place}sensor.zero_counts"))?,
            kpa_per_count: self.number(&format!("{place}sensor.kpa_per_count"))?,
        })
    }
}

/// Where something about a channel may stand, from the most general on.
fn places(board: u8, channel: usize) -> [String; 3] {
    [String::new(), format!("boards.{board}."), format!("boards.{board}.channels.{channel}.")]
}

/// Recordings and other files that are no text are given as rig files now and then.
fn unread(path: &Path, error: &std::io::Error) -> String {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
        std::io::ErrorKind::InvalidData if ["gz", "zst", "mcap"].contains(&ending) => {
            "expected a rig file (TOML), and this is a recording by its name".to_owned()
        }
        std::io::ErrorKind::InvalidData => "that is no text; a rig file is TOML".to_owned(),
        _ => error.to_string(),
    }
}
