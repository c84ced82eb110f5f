use thiserror::Error;

/// A 10-bit ADC reading of a pressure sensor, 0 to 1023: the unit of all values on the bus.
///
/// What a count means in kPa is [`SensorScale`](crate::SensorScale)'s business.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "u16", into = "u16")
)]
pub struct Counts(u16);

/// A number that is no 10-bit reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("{value} is not a 10-bit ADC reading (0 to 1023)")]
pub struct CountsError {
    /// The number that was refused.
    pub value: u16,
}

impl Counts {
    /// The smallest reading.
    pub const MIN: Self = Self(0);
    /// The largest reading.
    pub const MAX: Self = Self(1023);
    /// 0 kPa gauge on the original's sensor (102.4 counts, rounded): the command a board starts
    /// with.
    pub const ATMOSPHERE: Self = Self(102);

    /// Refuses anything above 1023.
    pub const fn new(value: u16) -> Result<Self, CountsError> {
        if value <= Self::MAX.0 { Ok(Self(value)) } else { Err(CountsError { value }) }
    }

    /// The nearest reading: larger numbers become 1023. For ADC results, never for what a user
    /// commands.
    pub const fn saturating(value: u16) -> Self {
        if value <= Self::MAX.0 { Self(value) } else { Self::MAX }
    }

    /// The number, 0 to 1023.
    pub const fn get(self) -> u16 {
        self.0
    }
}

impl TryFrom<u16> for Counts {
    type Error = CountsError;
    fn try_from(value: u16) -> Result<Self, CountsError> {
        Self::new(value)
    }
}

impl From<Counts> for u16 {
    fn from(counts: Counts) -> u16 {
        counts.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eleven_bits_are_refused_by_name() {
        assert_eq!(Counts::new(1023), Ok(Counts::MAX));
        let error = Counts::new(1024).unwrap_err();
        assert_eq!(std::format!("{error}"), "1024 is not a 10-bit ADC reading (0 to 1023)");
        assert_eq!(Counts::saturating(1024), Counts::MAX);
    }
}
