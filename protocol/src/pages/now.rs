use super::Entry;
use crate::{CHANNELS, Counts};

/// What a board and its channels did in the last control step: page 0, entry 0.
///
/// Word k has the status of channel k in its lowest 3 bits; word 0 has the board's state in the 3
/// bits above them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NowState {
    /// The board as a whole.
    pub board: StateNow,
    /// Channels 0 to 3.
    pub channels: [ChannelNow; CHANNELS],
}

/// What a board as a whole does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum StateNow {
    /// All channels vent after power-up.
    PowerUpVent = 0,
    /// Channels follow the host's commands.
    Running = 1,
    /// The host is silent; channels follow its last commands.
    Hold = 2,
    /// The host has been silent for too long; all channels vent.
    Vent = 3,
    /// Too many requests came damaged; all channels vent until the host leaves, or until power-up.
    DamageVent = 4,
}

/// What a channel does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ChannelNow {
    /// The valve follows the control law.
    Regulating = 0,
    /// The valve vents because the whole board does.
    Venting = 1,
    /// The valve vents because the sensor reads below its range.
    SensorBelowRange = 2,
    /// The valve vents because the sensor reads above its range.
    SensorAboveRange = 3,
    /// The channel is not in use; its valve vents.
    Disabled = 4,
}

impl StateNow {
    /// Its name in JSON: that of the variant, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PowerUpVent => "power_up_vent",
            Self::Running => "running",
            Self::Hold => "hold",
            Self::Vent => "vent",
            Self::DamageVent => "damage_vent",
        }
    }
}

impl ChannelNow {
    /// Its name in JSON: that of the variant, in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Regulating => "regulating",
            Self::Venting => "venting",
            Self::SensorBelowRange => "sensor_below_range",
            Self::SensorAboveRange => "sensor_above_range",
            Self::Disabled => "disabled",
        }
    }
}

impl NowState {
    const CHANNEL_BITS: u32 = 3;

    /// As it stands in a page answer.
    pub fn to_entry(&self) -> Entry {
        let mut words = self.channels.map(|channel| channel as u16);
        words[0] |= (self.board as u16) << Self::CHANNEL_BITS;
        words.map(Counts::saturating)
    }

    /// From a page answer; `None` if it has a number that stands for nothing.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let mut words = entry.map(Counts::get);
        let board = match words[0] >> Self::CHANNEL_BITS {
            0 => StateNow::PowerUpVent,
            1 => StateNow::Running,
            2 => StateNow::Hold,
            3 => StateNow::Vent,
            4 => StateNow::DamageVent,
            _ => return None,
        };
        words[0] &= (1 << Self::CHANNEL_BITS) - 1;
        let mut channels = [ChannelNow::Disabled; CHANNELS];
        for (channel, word) in channels.iter_mut().zip(words) {
            *channel = match word {
                0 => ChannelNow::Regulating,
                1 => ChannelNow::Venting,
                2 => ChannelNow::SensorBelowRange,
                3 => ChannelNow::SensorAboveRange,
                4 => ChannelNow::Disabled,
                _ => return None,
            };
        }
        Some(Self { board, channels })
    }
}

/// The drives that the last control step gave the four valves: page 0, entry 1. Word k is 512 + the
/// drive of valve k.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Drives([i16; CHANNELS]);

impl Drives {
    /// Full drive, in the original's counts.
    pub const FULL: i16 = 400;
    const ZERO: i16 = 512;

    /// From drive counts, -400 (vent fully) to 400 (fill fully); what lies beyond becomes that.
    pub fn new(counts: [i16; CHANNELS]) -> Self {
        Self(counts.map(|drive| drive.clamp(-Self::FULL, Self::FULL)))
    }

    /// Drive counts, -400 to 400.
    pub const fn counts(self) -> [i16; CHANNELS] {
        self.0
    }

    /// As a share of full drive: -1 (vent fully) to 1 (fill fully), the `u` of recordings.
    pub fn share(self) -> [f64; CHANNELS] {
        self.0.map(|drive| f64::from(drive) / f64::from(Self::FULL))
    }

    /// As it stands in a page answer.
    pub fn to_entry(self) -> Entry {
        self.0.map(|drive| Counts::saturating((drive + Self::ZERO).unsigned_abs()))
    }

    /// From a page answer; `None` if a word is no drive.
    pub fn from_entry(entry: Entry) -> Option<Self> {
        let drives = entry.map(|word| word.get().cast_signed() - Self::ZERO);
        drives.iter().all(|drive| drive.abs() <= Self::FULL).then_some(Self(drives))
    }
}
