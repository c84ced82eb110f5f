use crate::Counts;
use thiserror::Error;

/// The straight line between ADC counts and gauge pressure.
///
/// kPa = (counts - `zero_counts`) `kpa_per_count`. [`SensorScale::ORIGINAL`] is the original
/// board's sensor: ratiometric, 0.5 to 4.5 V over 0 to 100 psi, 10-bit ADC with a 5 V reference
/// read as counts/1024.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorScale {
    zero_counts: f64,
    kpa_per_count: f64,
    full_scale_kpa: f64,
}

/// A scale that no sensor can have.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ScaleError {
    /// The zero is not on the ADC's range.
    #[error("sensor zero is {0} counts; it must be a number from 0 to 1023")]
    Zero(f64),
    /// The slope is not a positive number.
    #[error("sensor slope is {0} kPa per count; it must be a positive number")]
    Slope(f64),
    /// The full scale is not positive or lies above the ADC's last code.
    #[error(
        "sensor full scale is {full_scale_kpa} kPa; it must be above 0 and at most {largest_kpa} kPa (1023 counts)"
    )]
    FullScale {
        /// The full scale that was refused, kPa gauge.
        full_scale_kpa: f64,
        /// Pressure of the ADC's last code, kPa gauge.
        largest_kpa: f64,
    },
}

/// A pressure that cannot be commanded.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum PressureError {
    /// NaN or infinite.
    #[error("commanded pressure is {0}, which is not a number of kPa")]
    NotFinite(f64),
    /// Below atmosphere.
    #[error("commanded pressure is {0} kPa; gauge pressures below 0 cannot be reached by venting")]
    Negative(f64),
    /// Above the sensor's range.
    #[error(
        "commanded pressure is {value_kpa} kPa, above the sensor's full scale of {full_scale_kpa:.1} kPa"
    )]
    AboveFullScale {
        /// The pressure that was refused, kPa gauge.
        value_kpa: f64,
        /// The largest pressure that the sensor can measure, kPa gauge.
        full_scale_kpa: f64,
    },
}

impl SensorScale {
    /// 100 psi in kPa (1 psi = 6.894757 kPa).
    const ORIGINAL_FULL_SCALE_KPA: f64 = 689.4757;

    /// The original board's sensor: zero at 102.4 counts, 0.841645 kPa a count, full scale 689.4757
    /// kPa.
    pub const ORIGINAL: Self = Self {
        zero_counts: 0.5 / 5.0 * 1024.0,
        kpa_per_count: 5.0 / 1024.0 / (4.5 - 0.5) * Self::ORIGINAL_FULL_SCALE_KPA,
        full_scale_kpa: Self::ORIGINAL_FULL_SCALE_KPA,
    };

    /// A scale from its zero (counts at 0 kPa gauge), slope (kPa a count) and full scale (kPa
    /// gauge).
    pub fn new(zero_counts: f64, kpa_per_count: f64, full_scale_kpa: f64) -> Result<Self, ScaleError> {
        let last = f64::from(Counts::MAX.get());
        if !(0.0..=last).contains(&zero_counts) {
            return Err(ScaleError::Zero(zero_counts));
        }
        if !(kpa_per_count > 0.0 && kpa_per_count.is_finite()) {
            return Err(ScaleError::Slope(kpa_per_count));
        }
        let largest_kpa = (last - zero_counts) * kpa_per_count;
        if !(full_scale_kpa > 0.0 && full_scale_kpa <= largest_kpa) {
            return Err(ScaleError::FullScale { full_scale_kpa, largest_kpa });
        }
        Ok(Self { zero_counts, kpa_per_count, full_scale_kpa })
    }

    /// Counts at 0 kPa gauge.
    pub const fn zero_counts(&self) -> f64 {
        self.zero_counts
    }

    /// kPa per count.
    pub const fn kpa_per_count(&self) -> f64 {
        self.kpa_per_count
    }

    /// The largest pressure that can be measured and commanded, kPa gauge.
    pub const fn full_scale_kpa(&self) -> f64 {
        self.full_scale_kpa
    }

    /// Gauge pressure of a reading, kPa. Readings below the zero give small negative pressures.
    pub fn kpa(&self, counts: Counts) -> f64 {
        (f64::from(counts.get()) - self.zero_counts) * self.kpa_per_count
    }

    /// Gauge pressure that a command means, kPa. The count of 0 kPa lies up to half a count below
    /// it, and a command below 0 kPa does not exist.
    pub fn command_kpa(&self, counts: Counts) -> f64 {
        self.kpa(counts).max(0.0)
    }

    /// The reading nearest to a commanded gauge pressure in kPa.
    ///
    /// # Errors
    /// NaN and infinities, negative pressures, and pressures above the full scale. Nothing is
    /// clamped.
    pub fn counts(&self, kpa: f64) -> Result<Counts, PressureError> {
        if !kpa.is_finite() {
            return Err(PressureError::NotFinite(kpa));
        }
        if kpa < 0.0 {
            return Err(PressureError::Negative(kpa));
        }
        if kpa > self.full_scale_kpa {
            return Err(PressureError::AboveFullScale {
                value_kpa: kpa,
                full_scale_kpa: self.full_scale_kpa,
            });
        }
        // Adding a half and cutting off rounds a non-negative number; `f64::round` needs std.
        Ok(Counts::saturating((kpa / self.kpa_per_count + self.zero_counts + 0.5) as u16))
    }
}

impl Default for SensorScale {
    fn default() -> Self {
        Self::ORIGINAL
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    const SCALE: SensorScale = SensorScale::ORIGINAL;

    #[test]
    fn the_originals_figures() {
        assert!((SCALE.zero_counts() - 102.4).abs() < 1e-12);
        assert!((SCALE.kpa_per_count() - 0.841645).abs() < 5e-7);
        // Full scale is 4.5 V of 5 V.
        assert_eq!(SCALE.counts(689.4757), Counts::new(922).map_err(|_| PressureError::NotFinite(0.0)));
        assert_eq!(SCALE.counts(0.0), Ok(Counts::ATMOSPHERE));
    }

    #[test]
    fn a_command_is_never_below_0_kpa_and_a_reading_may_be() {
        assert!(SCALE.kpa(Counts::ATMOSPHERE) < 0.0);
        assert_eq!(SCALE.command_kpa(Counts::ATMOSPHERE), 0.0);
        let counts = Counts::saturating(300);
        assert_eq!(SCALE.command_kpa(counts), SCALE.kpa(counts));
    }

    /// The original truncated, so that 509 of 1024 codes did not come back.
    #[test]
    fn every_code_that_can_be_commanded_comes_back() {
        for value in 103..=921 {
            let counts = Counts::new(value).unwrap();
            assert_eq!(SCALE.counts(SCALE.kpa(counts)), Ok(counts));
        }
    }

    #[test]
    fn what_cannot_be_commanded_is_named() {
        let say = |kpa: f64| SCALE.counts(kpa).unwrap_err().to_string();
        assert_eq!(say(f64::NAN), "commanded pressure is NaN, which is not a number of kPa");
        assert_eq!(say(f64::INFINITY), "commanded pressure is inf, which is not a number of kPa");
        assert_eq!(
            say(-100.0),
            "commanded pressure is -100 kPa; gauge pressures below 0 cannot be reached by venting"
        );
        assert_eq!(say(776.0), "commanded pressure is 776 kPa, above the sensor's full scale of 689.5 kPa");
        assert_eq!(SCALE.counts(-0.0), Ok(Counts::ATMOSPHERE));
    }

    #[test]
    fn impossible_scales_are_refused() {
        assert_eq!(SensorScale::new(-1.0, 0.8, 600.0), Err(ScaleError::Zero(-1.0)));
        assert_eq!(SensorScale::new(102.4, 0.0, 600.0), Err(ScaleError::Slope(0.0)));
        assert!(matches!(SensorScale::new(102.4, 0.5, 600.0), Err(ScaleError::FullScale { .. })));
        assert_eq!(
            SensorScale::new(SCALE.zero_counts(), SCALE.kpa_per_count(), SCALE.full_scale_kpa()),
            Ok(SensorScale::ORIGINAL)
        );
    }
}
