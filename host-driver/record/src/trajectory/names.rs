//! What the name of a column says to a trajectory.

use strsim::osa_distance;

/// What a column is to a trajectory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnName {
    /// `t_s`.
    Time,
    /// `b{n}_cmd{k}_kpa`.
    Command {
        /// The board's number.
        board: usize,
        /// The channel.
        channel: usize,
    },
    /// What recordings hold beside time and commands.
    Recorded,
    /// A command under a name that is none: left out, its channel would stay at 0 kPa.
    Misspelt {
        /// The name that it was most likely meant to have, if there is one.
        meant: Option<String>,
    },
    /// Somebody else's.
    Other,
}

/// Mistakes in a whole name, and in one without its unit, that still make it a command's.
const MOST_MISTAKES: usize = 2;
const MOST_MISTAKES_WITHOUT_UNIT: usize = 1;

/// Mistakes up to which a name is proposed.
const MOST_PROPOSED: usize = 3;

/// What recordings have for each board.
const OF_BOARD: [&str; 11] = [
    "qu_rad",
    "qv_rad",
    "supply_kpa",
    "ax_m_s2",
    "ay_m_s2",
    "az_m_s2",
    "gx_rad_s",
    "gy_rad_s",
    "gz_rad_s",
    "chip_c",
    "rail_v",
];

/// What they have for each channel: what is before its number, and after it.
const OF_CHANNEL: [(&str, &str); 4] = [("p", "_kpa"), ("u", ""), ("fill", ""), ("vent", "")];

impl ColumnName {
    /// What `name` says.
    pub fn of(name: &str) -> Self {
        if name == "t_s" {
            return Self::Time;
        }
        if let Some((board, channel)) = command(name) {
            return Self::Command { board, channel };
        }
        if is_recorded(name) {
            return Self::Recorded;
        }
        let name = name.to_ascii_lowercase();
        let meant = nearest_command(&name);
        let mistakes = |to: &str| osa_distance(&name, to);
        let is_near = meant.as_deref().is_some_and(|meant| {
            mistakes(meant) <= MOST_MISTAKES
                || mistakes(meant.trim_end_matches("_kpa")) <= MOST_MISTAKES_WITHOUT_UNIT
        });
        let is_called_so = name.contains("cmd") || name.contains("command");
        if !(is_near || is_called_so || has_the_shape(&name)) {
            return Self::Other;
        }
        let alike = |meant: &String| is_near || is_called_so || mistakes(meant) <= MOST_PROPOSED;
        Self::Misspelt { meant: meant.filter(alike) }
    }
}

/// Board and channel of a name of the form `b{n}_cmd{k}_kpa`.
fn command(name: &str) -> Option<(usize, usize)> {
    let (board, channel) = name.strip_prefix('b')?.strip_suffix("_kpa")?.split_once("_cmd")?;
    Some((plain(board)?, plain(channel)?))
}

fn is_recorded(name: &str) -> bool {
    if name == "supply_kpa" {
        return true;
    }
    let Some((board, quantity)) = name.strip_prefix('b').and_then(|rest| rest.split_once('_')) else {
        return false;
    };
    let of_channel = |(before, after): &(&str, &str)| {
        let channel = quantity.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
        channel.and_then(plain).is_some()
    };
    plain(board).is_some() && (OF_BOARD.contains(&quantity) || OF_CHANNEL.iter().any(of_channel))
}

/// A pressure of a channel that no recording has: `b{n}_{word}{k}_kpa`.
fn has_the_shape(name: &str) -> bool {
    let parts: Vec<&str> = name.split('_').collect();
    let [board, quantity, "kpa"] = parts.as_slice() else { return false };
    let word = quantity.trim_end_matches(|character: char| character.is_ascii_digit());
    board.strip_prefix('b').and_then(plain).is_some() && word.len() < quantity.len()
}

/// The command's name with the first two numbers of `name`, as its board and channel.
fn nearest_command(name: &str) -> Option<String> {
    let mut numbers =
        name.split(|character: char| !character.is_ascii_digit()).filter(|text| !text.is_empty());
    let (board, channel) = (numbers.next()?, numbers.next()?);
    Some(format!("b{board}_cmd{channel}_kpa"))
}

fn plain(digits: &str) -> Option<usize> {
    digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_command_is_known_and_the_right_name_is_proposed() {
        for name in [
            "b0_cdm1_kpa",
            "b0_cm1_kpa",
            "b0cmd1kpa",
            "b0_cmd1",
            "b0_cdm1",
            "b0_cmd1_bar",
            "B0_Cmd1_kPa",
            "b0_cmd_1_kpa",
            "b0_command1_kpa",
            "0_cmd1_kpa",
            "v0_cnd1_kpa",
            "b0_set1_kpa",
        ] {
            let meant = Some("b0_cmd1_kpa".to_owned());
            assert_eq!(ColumnName::of(name), ColumnName::Misspelt { meant }, "{name}");
        }
        for name in ["b0_cmd_kpa", "cmd", "b1_target0_kpa"] {
            assert_eq!(ColumnName::of(name), ColumnName::Misspelt { meant: None }, "{name}");
        }
    }

    #[test]
    fn columns_of_others_are_no_commands() {
        for name in ["note", "t", "time", "b0_p0_filtered_kpa", "temperature", "x0_y1", "b0_supply_bar", ""] {
            assert_eq!(ColumnName::of(name), ColumnName::Other, "{name}");
        }
    }

    /// Recordings are trajectories, with all that they can hold.
    #[test]
    fn every_column_of_a_recording_is_known() {
        use crate::{Formatter, PageColumns};
        let pages = PageColumns { drives: true, sensors: true };
        let header = Formatter::new(&[0, 12], &pneudrive_host::Calibration::default(), pages).header();
        for name in String::from_utf8(header).unwrap().trim_end().split(',') {
            let known = match ColumnName::of(name) {
                ColumnName::Time | ColumnName::Recorded => !name.contains("cmd"),
                ColumnName::Command { .. } => name.contains("cmd"),
                ColumnName::Misspelt { .. } | ColumnName::Other => false,
            };
            assert!(known, "{name}");
        }
        for name in ["supply_kpa", "b3_qu_rad", "b3_qv_rad", "b3_fill0", "b3_vent12"] {
            assert_eq!(ColumnName::of(name), ColumnName::Recorded, "{name}");
        }
    }
}
