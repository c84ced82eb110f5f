//! Columns of what a board measures beside its pressures.

use super::rows::Sample;
use pneudrive_host::poller::Motion;
use std::io::Write;

/// Their names, behind `b{n}_`.
pub(super) const SENSOR_COLUMNS: [&str; 9] =
    ["supply_kpa", "ax_m_s2", "ay_m_s2", "az_m_s2", "gx_rad_s", "gy_rad_s", "gz_rad_s", "chip_c", "rail_v"];

/// Appends their cells, with as many digits as pages have; empty where nothing came in this cycle.
pub(super) fn append(text: &mut Vec<u8>, sample: &Sample) {
    cell(text, sample.supply.map(|supply| supply.kpa), 2);
    // Writing to a Vec does not fail.
    let _ = match sample.motion {
        Some(Motion { acceleration_m_s2: [ax, ay, az], angular_rate_rad_s: [gx, gy, gz], .. }) => {
            write!(text, ",{ax:.2},{ay:.2},{az:.2},{gx:.4},{gy:.4},{gz:.4}")
        }
        None => write!(text, ",,,,,,"),
    };
    cell(text, sample.electronics.and_then(|electronics| electronics.chip_c), 1);
    cell(text, sample.electronics.and_then(|electronics| electronics.rail_v), 2);
}

fn cell(text: &mut Vec<u8>, value: Option<f64>, digits: usize) {
    // As above.
    let _ = match value {
        Some(value) => write!(text, ",{value:.digits$}"),
        None => write!(text, ","),
    };
}
