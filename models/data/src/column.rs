//! What a column's name says: the quantity, its unit and whose it is.

use super::ChannelId;

/// A column of the measured-data format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ColumnKind {
    /// `t_s`
    Time,
    /// `b{n}_cmd{k}_kpa`
    Command(ChannelId),
    /// `b{n}_p{k}_kpa`
    Pressure(ChannelId),
    /// `b{n}_u{k}`
    Spool(ChannelId),
    /// `b{n}_fill{k}`
    Fill(ChannelId),
    /// `b{n}_vent{k}`
    Vent(ChannelId),
    /// `b{n}_qu_rad`
    JointU(u8),
    /// `b{n}_qv_rad`
    JointV(u8),
    /// `supply_kpa`
    Supply,
    /// `b{n}_supply_kpa`
    BoardSupply(u8),
}

/// The range a column's values must keep, and what a value outside most likely is.
pub(crate) struct ValidRange {
    pub low: f64,
    pub high: f64,
    pub advice: &'static str,
}

impl ValidRange {
    /// Whether `value` is inside, or missing (`NaN`), which is not a question of range.
    pub(crate) fn admits(&self, value: f64) -> bool {
        const SLACK: f64 = 1e-6; // a full drive written with few digits
        value.is_nan() || (value >= self.low - SLACK && value <= self.high + SLACK)
    }
}

impl ColumnKind {
    /// What `name` means, or `None` for a column of somebody else's.
    pub(crate) fn parse(name: &str) -> Option<Self> {
        match name {
            "t_s" => return Some(Self::Time),
            "supply_kpa" => return Some(Self::Supply),
            _ => {}
        }
        let (board, quantity) = name.strip_prefix('b')?.split_once('_')?;
        let board = number(board)?;
        match quantity {
            "qu_rad" => return Some(Self::JointU(board)),
            "qv_rad" => return Some(Self::JointV(board)),
            "supply_kpa" => return Some(Self::BoardSupply(board)),
            _ => {}
        }
        let id = |text: &str| Some(ChannelId { board, channel: number(text)? });
        if let Some(rest) = quantity.strip_suffix("_kpa") {
            if let Some(k) = rest.strip_prefix("cmd") {
                return id(k).map(Self::Command);
            }
            return id(rest.strip_prefix('p')?).map(Self::Pressure);
        }
        if let Some(k) = quantity.strip_prefix("fill") {
            return id(k).map(Self::Fill);
        }
        if let Some(k) = quantity.strip_prefix("vent") {
            return id(k).map(Self::Vent);
        }
        id(quantity.strip_prefix('u')?).map(Self::Spool)
    }

    /// The column's name: what [`parse`](Self::parse) understands.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Time => "t_s".to_owned(),
            Self::Command(id) => id.command_column(),
            Self::Pressure(id) => id.pressure_column(),
            Self::Spool(id) => id.drive_column(),
            Self::Fill(id) => id.fill_vent_columns().0,
            Self::Vent(id) => id.fill_vent_columns().1,
            Self::JointU(board) => format!("b{board}_qu_rad"),
            Self::JointV(board) => format!("b{board}_qv_rad"),
            Self::Supply => "supply_kpa".to_owned(),
            Self::BoardSupply(board) => format!("b{board}_supply_kpa"),
        }
    }

    /// The channel this column belongs to, if it is a channel's.
    #[must_use]
    pub fn channel(self) -> Option<ChannelId> {
        match self {
            Self::Command(id) | Self::Pressure(id) | Self::Spool(id) | Self::Fill(id) | Self::Vent(id) => {
                Some(id)
            }
            Self::Time | Self::JointU(_) | Self::JointV(_) | Self::Supply | Self::BoardSupply(_) => None,
        }
    }

    /// Where the format itself bounds the values. What pressures are possible is the rig's
    /// business, but beyond a million bar (and in the end beyond single precision) there is none.
    pub(crate) fn valid_range(self) -> ValidRange {
        match self {
            Self::Time => ValidRange {
                // Nanoseconds since 1970 are 1.8e18: what they are is said when the sampling rate
                // is known.
                low: -1e19,
                high: 1e19,
                advice: "t_s is in seconds",
            },
            Self::Command(_) | Self::Pressure(_) | Self::Supply | Self::BoardSupply(_) => ValidRange {
                low: -1e8,
                high: 1e8,
                advice: "that is no pressure in kPa; leave the cell empty where there is none",
            },
            Self::Spool(_) => ValidRange {
                low: -1.0,
                high: 1.0,
                advice: "a drive runs from -1 (vent) to 1 (fill): divide by the full-scale drive, or import it with a scale",
            },
            Self::Fill(_) | Self::Vent(_) => ValidRange {
                low: 0.0,
                high: 1.0,
                advice: "a separate drive runs from 0 (closed) to 1 (open): divide by 100 if it is in percent",
            },
            Self::JointU(_) | Self::JointV(_) => ValidRange {
                low: -std::f64::consts::TAU,
                high: std::f64::consts::TAU,
                advice: "joint angles are in rad: import them with the unit deg if they are in degrees",
            },
        }
    }
}

/// A plain decimal number without sign, as in `b0` or `cmd12`.
fn number(text: &str) -> Option<u8> {
    (text.bytes().all(|b| b.is_ascii_digit())).then(|| text.parse().ok()).flatten()
}

/// For a column that is not of the format but looks as if it was meant to be: the name it may have
/// been meant for.
pub(crate) fn near_miss(name: &str) -> Option<String> {
    let folded = name.trim().to_ascii_lowercase().replace(['-', ' '], "_");
    for candidate in [folded.clone(), with_digits(&folded)] {
        if ColumnKind::parse(&candidate).is_some() && candidate != name {
            return Some(candidate);
        }
    }
    let stem = folded.trim_end_matches(|c: char| c.is_ascii_alphabetic()).trim_end_matches('_');
    [format!("{stem}_kpa"), format!("{stem}_rad")].into_iter().find(|candidate| {
        *candidate != name && ColumnKind::parse(candidate).is_some() && ColumnKind::parse(name).is_none()
    })
}

/// With letters that are taken for digits, where a digit may stand, as in `b0_pO_kpa`.
fn with_digits(name: &str) -> String {
    let word = |word: &str| match word.find(['o', 'l', 'i']) {
        Some(at) if at > 0 && word != "kpa" => word.replace('o', "0").replace(['l', 'i'], "1"),
        _ => word.to_owned(),
    };
    name.split('_').map(word).collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    const B0C2: ChannelId = ChannelId { board: 0, channel: 2 };

    #[test]
    fn every_column_of_the_format_is_known() {
        for (name, kind) in [
            ("t_s", ColumnKind::Time),
            ("b0_cmd2_kpa", ColumnKind::Command(B0C2)),
            ("b0_p2_kpa", ColumnKind::Pressure(B0C2)),
            ("b0_u2", ColumnKind::Spool(B0C2)),
            ("b0_fill2", ColumnKind::Fill(B0C2)),
            ("b0_vent2", ColumnKind::Vent(B0C2)),
            ("b3_qu_rad", ColumnKind::JointU(3)),
            ("b3_qv_rad", ColumnKind::JointV(3)),
            ("supply_kpa", ColumnKind::Supply),
            ("b3_supply_kpa", ColumnKind::BoardSupply(3)),
        ] {
            assert_eq!(ColumnKind::parse(name), Some(kind), "{name}");
            assert_eq!(kind.name(), name);
        }
    }

    #[test]
    fn foreign_columns_are_not_ours() {
        for name in
            ["dp_inhale", "b_p0_kpa", "b0_p_kpa", "b0_p0", "b0_p+1_kpa", "b0_u", "t", "b0_p0_psi", "b999_u0"]
        {
            assert_eq!(ColumnKind::parse(name), None, "{name}");
        }
    }

    #[test]
    fn near_misses_name_what_was_meant() {
        assert_eq!(near_miss("b0_p0_psi").as_deref(), Some("b0_p0_kpa"));
        assert_eq!(near_miss("b0_p0").as_deref(), Some("b0_p0_kpa"));
        assert_eq!(near_miss("B0_P0_kPa").as_deref(), Some("b0_p0_kpa"));
        assert_eq!(near_miss("b0_qu_deg").as_deref(), Some("b0_qu_rad"));
        assert_eq!(near_miss("b0_pO_kpa").as_deref(), Some("b0_p0_kpa"), "a letter for a digit");
        assert_eq!(near_miss("bO_cmdl_kpa").as_deref(), Some("b0_cmd1_kpa"));
        assert_eq!(near_miss("b0-p0-kpa").as_deref(), Some("b0_p0_kpa"));
        assert_eq!(near_miss("dp_inhale"), None);
        assert_eq!(near_miss("b0_note"), None);
    }
}
