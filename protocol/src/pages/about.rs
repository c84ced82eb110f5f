use super::Entry;
use crate::Counts;
use core::fmt;

/// What a board is: page 2, entry 0. Words: chip, then major, minor and patch level of its version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct About {
    /// What it runs on.
    pub chip: ChipKind,
    /// Major, minor and patch level, each 0 to 1023.
    pub version: [u16; 3],
}

/// What a board runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ChipKind {
    /// The control crate by itself, as in the simulator.
    Native,
    /// RP2040.
    Rp2040,
    /// RP2350.
    Rp2350,
    /// What this version of the crate does not know, by its number: 3 to 255.
    Other(u8),
}

impl fmt::Display for ChipKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Native => f.write_str("no chip (simulated)"),
            Self::Rp2040 => f.write_str("RP2040"),
            Self::Rp2350 => f.write_str("RP2350"),
            Self::Other(number) => write!(f, "unknown chip {number}"),
        }
    }
}

impl ChipKind {
    /// Its number in pages and programs.
    pub const fn number(self) -> u8 {
        match self {
            Self::Native => 0,
            Self::Rp2040 => 1,
            Self::Rp2350 => 2,
            Self::Other(number) => number,
        }
    }

    /// The chip with this number.
    pub const fn of_number(number: u8) -> Self {
        match number {
            0 => Self::Native,
            1 => Self::Rp2040,
            2 => Self::Rp2350,
            number => Self::Other(number),
        }
    }
}

impl About {
    /// As it stands in a page answer. Larger version numbers than 1023 become that.
    pub fn to_entry(&self) -> Entry {
        let chip = self.chip.number();
        let [major, minor, patch] = self.version;
        [chip.into(), major, minor, patch].map(Counts::saturating)
    }

    /// From a page answer; `None` if its first word is no chip.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let [chip, major, minor, patch] = entry.map(Counts::get);
        let chip = ChipKind::of_number(u8::try_from(chip).ok()?);
        Some(Self { chip, version: [major, minor, patch] })
    }
}
