//! What is measured of a channel, in which unit, and how large it may be.

use serde::{Deserialize, Serialize};

/// Something that is measured of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Reading of the vented chamber, kPa.
    Zero,
    /// Standard deviation of single readings at rest, kPa.
    Noise,
    /// Deviation from the highest set point at the end of its hold, kPa: the supply is too low, or
    /// the chamber leaks.
    Reached,
    /// Rise of the pressure with the valve driven fully, kPa/s.
    FillRate,
    /// Fall of the pressure with the valve driven fully, kPa/s.
    VentRate,
    /// From the command to the line on which the pressure rises, ms.
    DeadTime,
    /// Between the pressures at which filling and venting stop, kPa: the valve's dead band in terms
    /// of the board's loop.
    Threshold,
    /// Where the middle of that dead band is, beside the set point, kPa.
    Centre,
    /// Fall of the pressure while it is itself the set point, kPa/s, so that the valve is closed: a
    /// leak to the air. Below 0 it rises: a leak from the supply.
    Leak,
    /// Deviation from half the level at the end of its hold, kPa.
    Hold,
    /// Largest deviation of another channel at 0 kPa while this one is filled and held, kPa.
    Crosstalk,
}

/// A unit, and how many decimals say enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// As it is written.
    pub name: &'static str,
    /// Digits behind the point.
    pub decimals: usize,
}

/// What a value may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Limits {
    /// Its magnitude, up to where it passes and where it only warns.
    Magnitude(f64, f64),
    /// How many times as much or as little as the rig's other channels have.
    Ratio(f64, f64),
}

impl Quantity {
    /// All of them, in the order in which they are shown.
    pub const ALL: [Self; 11] = [
        Self::Zero,
        Self::Noise,
        Self::Reached,
        Self::FillRate,
        Self::VentRate,
        Self::DeadTime,
        Self::Threshold,
        Self::Centre,
        Self::Leak,
        Self::Hold,
        Self::Crosstalk,
    ];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Zero => "sensor zero",
            Self::Noise => "sensor noise",
            Self::Reached => "level reached",
            Self::FillRate => "fill rate",
            Self::VentRate => "vent rate",
            Self::DeadTime => "dead time",
            Self::Threshold => "valve threshold",
            Self::Centre => "valve centre",
            Self::Leak => "leak",
            Self::Hold => "hold",
            Self::Crosstalk => "crosstalk",
        }
    }

    /// Of its values.
    pub fn unit(self) -> Unit {
        let (name, decimals) = match self {
            Self::FillRate | Self::VentRate => ("kPa/s", 0),
            Self::Leak => ("kPa/s", 2),
            Self::DeadTime => ("ms", 1),
            _ => ("kPa", 2),
        };
        Unit { name, decimals }
    }

    /// Without an earlier check. The numbers are what a rig can have and still work:
    /// `docs/check.md` says why each.
    pub(crate) fn limits(self) -> Limits {
        match self {
            Self::Zero => Limits::Magnitude(7.0, 25.0),
            Self::Noise => Limits::Magnitude(2.0, 6.0),
            Self::Reached => Limits::Magnitude(6.0, 20.0),
            Self::FillRate | Self::VentRate => Limits::Ratio(1.5, 3.0),
            Self::DeadTime => Limits::Magnitude(30.0, 100.0),
            Self::Threshold => Limits::Magnitude(10.0, 25.0),
            Self::Centre => Limits::Magnitude(4.0, 12.0),
            Self::Leak => Limits::Magnitude(6.0, 20.0),
            Self::Hold => Limits::Magnitude(5.0, 15.0),
            Self::Crosstalk => Limits::Magnitude(4.0, 15.0),
        }
    }

    /// How much it may differ from an earlier check: an amount, or for rates a factor's logarithm.
    pub(crate) fn tolerance(self) -> f64 {
        match self {
            Self::Zero | Self::Crosstalk => 1.0,
            // A count is 0.84 kPa: how much noise it shows depends on where between two counts the
            // pressure is.
            Self::Noise => 0.8,
            Self::Reached | Self::Hold => 0.5,
            Self::FillRate | Self::VentRate => 0.05,
            Self::DeadTime => 2.5,
            Self::Threshold => 0.8,
            Self::Centre => 0.45,
            Self::Leak => 1.5,
        }
    }

    /// Whether both signs occur.
    pub(crate) fn is_signed(self) -> bool {
        matches!(self, Self::Zero | Self::Reached | Self::Centre | Self::Leak | Self::Hold)
    }

    /// Whether changes are factors.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::FillRate | Self::VentRate)
    }
}
