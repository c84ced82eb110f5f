//! What the converter of the supply pressure and the IMU send, in the units of pages.

use pneudrive_protocol::pages::{Acceleration, AngularRate, GaugePressure};

/// A pressure transducer whose output is 10 % of its supply at 0 and 90 % at full scale, above the
/// atmosphere.
///
/// ```
/// use pneudrive_control::Transducer;
///
/// let transducer = Transducer { full_scale_pa: 1_000_000 };
/// // Half way between 0.5 and 4.5 V.
/// let pressure = transducer.pressure(2_500_000, 5_000_000).map(|pressure| pressure.pa());
/// assert_eq!(pressure, Some(500_000));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transducer {
    /// The pressure at 90 % of the supply, Pa; 1 to 2,000,000.
    pub full_scale_pa: i32,
}

impl Transducer {
    /// Least and largest supply of a 5 V transducer that is connected, uV.
    pub const SUPPLY_UV: core::ops::RangeInclusive<i32> = 4_000_000..=5_600_000;

    /// From its output and its supply, uV. `None` where one of them says that something is not
    /// connected: a supply outside [`SUPPLY_UV`](Self::SUPPLY_UV), an output below 5 % or above 95
    /// % of it.
    pub fn pressure(self, output_uv: i32, supply_uv: i32) -> Option<GaugePressure> {
        let percents = |percents: i32| supply_uv / 100 * percents;
        if !Self::SUPPLY_UV.contains(&supply_uv) || !(percents(5)..=percents(95)).contains(&output_uv) {
            return None;
        }
        let (output, supply) = (i64::from(output_uv), i64::from(supply_uv));
        let pa = (10 * output - supply) * i64::from(self.full_scale_pa) / (8 * supply);
        i32::try_from(pa).ok().map(GaugePressure::from_pa)
    }
}

/// Steps of an [`Acceleration`] from a 16-bit reading whose full scale is 4 g.
pub const fn acceleration_steps(reading: i16) -> i16 {
    // 980.665 / 8192, 980.665 being g in cm/s^2.
    scaled(reading, 15_691)
}

/// Steps of an [`AngularRate`] from a 16-bit reading whose full scale is 500 degrees/s.
pub const fn angular_rate_steps(reading: i16) -> i16 {
    // 400 x 500 x pi / 180 / 32768.
    scaled(reading, 13_963)
}

/// `reading` times `factor` / 2^17, to the nearest; `factor` is at most 2^15.
const fn scaled(reading: i16, factor: i32) -> i16 {
    ((reading as i32 * factor + (1 << 16)) >> 17) as i16
}

const _: () = assert!(Acceleration::STEPS_PER_M_PER_S2 == 100 && AngularRate::STEPS_PER_RAD_PER_S == 400);

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    const TRANSDUCER: Transducer = Transducer { full_scale_pa: 1_000_000 };

    #[test]
    fn pressure_is_the_share_of_the_supply() {
        for supply_uv in [4_750_000, 5_000_000, 5_250_000] {
            for (share, pa) in [(0.1, 0), (0.9, 1_000_000), (0.5, 500_000), (0.06, -50_000)] {
                let output_uv = (f64::from(supply_uv) * share) as i32;
                let pressure = TRANSDUCER.pressure(output_uv, supply_uv).unwrap();
                assert!((pressure.pa() - pa).abs() <= 10, "{share} of {supply_uv} uV: {pressure:?}");
            }
        }
    }

    #[test]
    fn what_is_not_connected_has_no_pressure() {
        let supply = 5_000_000;
        for (output_uv, supply_uv) in [
            (0, supply),
            (249_000, supply),
            (4_751_000, supply),
            (supply, supply),
            (2_500_000, 0),
            (2_500_000, 3_999_999),
            (2_500_000, 5_600_001),
            (i32::MIN, i32::MAX),
            (-1, -1),
        ] {
            assert_eq!(TRANSDUCER.pressure(output_uv, supply_uv), None, "{output_uv} of {supply_uv} uV");
        }
    }

    /// Half a step of rounding, and 3 of 100,000 of the factor: 0.12 steps at the most.
    #[test]
    fn readings_become_the_nearest_steps() {
        for reading in i16::MIN..=i16::MAX {
            let share = f64::from(reading) / 32_768.0;
            let acceleration = share * 4.0 * 9.806_65 * 100.0;
            let rate = share * 500.0 * PI / 180.0 * 400.0;
            assert!((f64::from(acceleration_steps(reading)) - acceleration).abs() < 0.62, "{reading}");
            assert!((f64::from(angular_rate_steps(reading)) - rate).abs() < 0.62, "{reading}");
        }
    }
}
