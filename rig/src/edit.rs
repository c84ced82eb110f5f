//! Writing rig files: a new one, and a calibration into one that people have written.

use crate::{Rig, RigError, Sensor, Unit};
use std::fmt::Write as _;
use toml_edit::{DocumentMut, Item, Table, value};

/// What a board's channels may be called, in comments of a new file.
const EXAMPLES: [&str; crate::CHANNELS] = ["left", "right", "front", "back"];

/// A rig file to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRig {
    /// Serial port, or `sim`.
    pub port: String,
    /// Line rate, bit/s.
    pub baud: u32,
    /// The boards, numbered from 0, and what is known of each: a comment.
    pub boards: Vec<String>,
    /// The unit in which people see pressures.
    pub unit: Unit,
}

impl NewRig {
    /// The file's text, with every key explained.
    #[must_use]
    pub fn text(&self) -> String {
        let mut port = toml_edit::Value::from(self.port.as_str());
        port.decor_mut().clear();
        let (baud, count, unit) = (self.baud, self.boards.len(), self.unit.name());
        // Of virtual boards all is known.
        let (off, virtual_note) =
            if self.port == "sim" { ("", " Virtual boards have these:") } else { ("# ", "") };
        let mut text = format!(
            "\
# A PneuDrive rig. docs/rig.md of the project explains every key. Lines that begin with # are off.

[bus]
port = {port}
boards = {count}
baud = {baud}
# rate_hz = 500.0               # cycles per second; as fast as possible without it

[display]
unit = \"{unit}\"                    # kPa, bar or psi

# [limits]                      # of every channel of every board
# max_kpa = 300.0               # highest set point, kPa gauge: what is above it is refused
# max_rate_kpa_s = 500.0        # fastest change of a set point: what is faster is ramped

[sensor]                        # of every channel without a calibration of its own (pneudrive-host calibrate)
bits = 10
zero_counts = 102.4             # reading at 0 kPa gauge
kpa_per_count = 0.841645        # pressure of one count; nominal for the 100 psi sensor

[controller]                    # the loop on the boards as the firmware has it by default
rate_hz = 1000.0
kp = 10.0
kd = 20.0
saturation = 400.0
filter = 0.8203125

# What the toolkit wants to know of the machine; it need not be known to run it.{virtual_note}
{off}[supply]
{off}pressure_kpa = 550.0            # gauge
{off}[chamber]
{off}radius_m = 0.024
{off}length_m = 0.20
{off}offset_m = 0.045
"
        );
        for (board, known) in self.boards.iter().enumerate() {
            // Writing to a String does not fail.
            let _ = write!(
                text,
                "\n[boards.{board}]                      # {}\n# name = \"shoulder\"\n",
                known.replace(char::is_control, " ")
            );
            for (channel, example) in EXAMPLES.iter().enumerate() {
                let _ = writeln!(text, "[boards.{board}.channels.{channel}]\n# name = \"{example}\"");
            }
        }
        text
    }
}

/// The rig file `text` with the calibration of one channel, all else as it was, comments included.
/// `note` says beside the table where the numbers come from.
///
/// # Errors
/// `text` is no rig file, or would not be one with these numbers.
pub fn with_sensor(
    file: &str,
    text: &str,
    (board, channel): (u8, usize),
    sensor: Sensor,
    note: &str,
) -> Result<String, RigError> {
    Rig::parse(file, text)?;
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| RigError::Syntax {
        file: file.to_owned(),
        line: 1,
        problem: error.message().to_owned(),
    })?;
    let path = ["boards", &board.to_string(), "channels", &channel.to_string()];
    let mut table: &mut Item = document.as_item_mut();
    for name in path {
        let inner = table.as_table_like_mut().map(|table| {
            let implicit = || {
                let mut made = Table::new();
                made.set_implicit(true);
                Item::Table(made)
            };
            table.entry(name).or_insert_with(implicit)
        });
        // The file has been read: where a table is, it is one.
        let Some(inner) = inner else { return Ok(text.to_owned()) };
        table = inner;
    }
    let mut calibration = Table::new();
    calibration.insert("zero_counts", value(round(sensor.zero_counts, 2)));
    calibration.insert("kpa_per_count", value(round(sensor.kpa_per_count, 6)));
    let note = note.replace(char::is_control, " ");
    calibration.decor_mut().set_suffix(format!("  # {note}"));
    if let Some(table) = table.as_table_like_mut() {
        table.insert("sensor", Item::Table(calibration));
    }
    let written = document.to_string();
    Rig::parse(file, &written)?;
    Ok(written)
}

fn round(number: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (number * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_file_is_read_again() {
        let new = NewRig {
            port: "/dev/serial/by-id/usb-\"odd\\name".into(),
            baud: 1_000_000,
            boards: vec!["answers in checked packets\n".into(), "original packets".into()],
            unit: Unit::Bar,
        };
        let rig = Rig::parse("new.toml", &new.text()).unwrap();
        assert_eq!(rig.bus().port.as_deref(), Some(new.port.as_str()));
        assert_eq!((rig.bus().boards, rig.bus().baud), (Some(2), Some(1_000_000)));
        assert_eq!(rig.unit(), Unit::Bar);
        assert_eq!(
            (rig.board_name(1), rig.channel_name(1, 3)),
            (None, None),
            "names are for the user to give"
        );
        assert_eq!(rig.boards().len(), 2);
    }

    /// A fit to a recording of virtual boards needs no editor in between.
    #[test]
    fn what_virtual_boards_are_made_of_is_known() {
        let new = |port: &str| NewRig {
            port: port.into(),
            baud: 1_000_000,
            boards: vec!["no chip".into()],
            unit: Unit::Kpa,
        };
        let rig = |port: &str| Rig::parse("new.toml", &new(port).text()).unwrap();
        assert_eq!(rig("sim").number("supply.pressure_kpa"), Some(550.0));
        assert_eq!(rig("sim").number("chamber.radius_m"), Some(0.024));
        assert_eq!(rig("/dev/ttyUSB0").number("supply.pressure_kpa"), None);
    }

    #[test]
    fn a_calibration_is_written_and_all_else_stays() {
        let text = "# ours\n[limits]\nmax_kpa = 300 # high\n\n[boards.1]\nname = \"arm\"\n[boards.1.channels.2]\nname = \"left\"\n";
        let first = Sensor { zero_counts: 103.456, kpa_per_count: 0.840_123_4 };
        let once = with_sensor("rig.toml", text, (1, 2), first, "at 0 and 200 kPa").unwrap();
        assert!(once.starts_with(text), "{once}");
        assert!(once.contains("[boards.1.channels.2.sensor]  # at 0 and 200 kPa\n"), "{once}");
        let rig = Rig::parse("rig.toml", &once).unwrap();
        let read = rig.sensor(1, 2).unwrap();
        assert_eq!((read.zero_counts, read.kpa_per_count), (103.46, 0.840_123));
        assert_eq!((rig.channel_name(1, 2), rig.sensor(1, 1)), (Some("left"), None));

        // Again, and for a board that the file did not name.
        let second = Sensor { zero_counts: 99.0, kpa_per_count: 0.83 };
        let twice = with_sensor("rig.toml", &once, (1, 2), second, "again").unwrap();
        let twice = with_sensor("rig.toml", &twice, (3, 0), first, "new").unwrap();
        let rig = Rig::parse("rig.toml", &twice).unwrap();
        assert_eq!(rig.sensor(1, 2), Some(second));
        assert_eq!(rig.sensor(3, 0).map(|sensor| sensor.zero_counts), Some(103.46));
        assert_eq!(twice.matches("channels.2.sensor").count(), 1, "{twice}");
        assert!(twice.contains("max_kpa = 300 # high"), "{twice}");
    }

    #[test]
    fn numbers_that_the_reader_refuses_are_not_written() {
        let sensor = Sensor { zero_counts: 100.0, kpa_per_count: -1.0 };
        let refused = with_sensor("rig.toml", "", (0, 0), sensor, "").unwrap_err().to_string();
        assert!(refused.contains("boards.0.channels.0.sensor.kpa_per_count = -1.0"), "{refused}");
    }
}
