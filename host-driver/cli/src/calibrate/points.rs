//! The line through two points, and whether it can be a sensor's.

use pneudrive_host::rig::Sensor;
use pneudrive_protocol::SensorScale;

/// What a channel reads at a pressure that was measured otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Mean reading, counts.
    pub counts: f64,
    /// Pressure on the reference gauge, kPa gauge.
    pub kpa: f64,
}

/// The least distance of the points, counts: below it their noise makes the slope.
const LEAST_COUNTS: f64 = 50.0;
/// How far a slope may be from the nominal one. Parts of 1 % give 2 %; 15 % is another sensor, or a
/// gauge that was misread.
const LARGEST_DEVIATION: f64 = 0.15;
/// How far a zero may be from the nominal one, counts.
const LARGEST_ZERO: f64 = 60.0;

/// The calibration that both points lie on, or why there is none.
pub fn through(low: Point, high: Point) -> Result<Sensor, String> {
    let (counts, kpa) = (high.counts - low.counts, high.kpa - low.kpa);
    // Written so that NaN is refused.
    if !(counts >= LEAST_COUNTS && kpa > 0.0) {
        return Err(format!(
            "the points are {counts:.1} counts and {kpa:.1} kPa apart: expected at least {LEAST_COUNTS} counts, and the higher \
             pressure second"
        ));
    }
    let kpa_per_count = kpa / counts;
    let zero_counts = low.counts - low.kpa / kpa_per_count;
    let nominal = SensorScale::ORIGINAL;
    let deviation = kpa_per_count / nominal.kpa_per_count() - 1.0;
    if deviation.abs() > LARGEST_DEVIATION || (zero_counts - nominal.zero_counts()).abs() > LARGEST_ZERO {
        return Err(format!(
            "{kpa_per_count:.4} kPa per count with its zero at {zero_counts:.1} counts is no 100 psi sensor ({:.4} kPa per count, \
             zero at {}): was the gauge read in the right unit, and at the right channel?",
            nominal.kpa_per_count(),
            nominal.zero_counts()
        ));
    }
    Ok(Sensor { zero_counts, kpa_per_count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_points_lie_on_the_line() {
        let (low, high) = (Point { counts: 160.0, kpa: 48.0 }, Point { counts: 340.0, kpa: 201.0 });
        let sensor = through(low, high).unwrap();
        for point in [low, high] {
            let kpa = (point.counts - sensor.zero_counts) * sensor.kpa_per_count;
            assert!((kpa - point.kpa).abs() < 1e-9, "{kpa}");
        }
        assert!((sensor.kpa_per_count - 0.85).abs() < 1e-12);
    }

    #[test]
    fn what_no_sensor_reads_is_refused() {
        let low = Point { counts: 160.0, kpa: 48.5 };
        let refused = |counts, kpa| through(low, Point { counts, kpa }).unwrap_err();
        assert!(refused(200.0, 82.0).contains("at least 50 counts"));
        assert!(refused(340.0, 30.0).contains("the higher pressure second"));
        // Read in psi.
        assert!(refused(340.0, 29.0 + 48.5).contains("no 100 psi sensor"));
        assert!(refused(340.0, f64::NAN).contains("apart"));
        let shifted = through(Point { counts: 60.0, kpa: 48.5 }, Point { counts: 240.0, kpa: 200.0 });
        assert!(shifted.unwrap_err().contains("zero at 2."));
    }
}
