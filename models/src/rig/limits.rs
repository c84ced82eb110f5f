//! `[limits]` and `[boards]`: set points that the host refuses. Here they bound what experiments command.

use super::RigError;
use super::check::Checker;

/// The tables that are for those who work with the boards: what may be commanded, and how they are reached and shown.
pub(super) const TABLES: [&str; 4] = ["limits", "boards", "bus", "display"];

/// Takes the limits out of `rig`; the lowest `max_kpa` of any board and channel, kPa gauge.
///
/// The host checks the rest of these tables: it is the one that enforces them.
pub(super) fn take(rig: &mut toml::Table, file: &str) -> Result<Option<f64>, RigError> {
    let mut lowest = None;
    for table in TABLES {
        if let Some(value) = rig.remove(table) {
            lowest_in(&value, file, &mut lowest)?;
        }
    }
    Ok(lowest)
}

fn lowest_in(value: &toml::Value, file: &str, lowest: &mut Option<f64>) -> Result<(), RigError> {
    let Some(table) = value.as_table() else { return Ok(()) };
    for (key, value) in table {
        let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        match number {
            Some(kpa) if key == "max_kpa" => {
                let advice = "it is the highest gauge pressure that may be commanded";
                Checker { file }.within("limits.max_kpa", kpa, (0.0, 2000.0), "kPa", advice)?;
                *lowest = Some(lowest.map_or(kpa, |lowest: f64| lowest.min(kpa)));
            }
            _ => lowest_in(value, file, lowest)?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::rig::Rig;

    #[test]
    fn the_lowest_maximum_of_all_channels_bounds_experiments() {
        let text = "[supply]\npressure_kpa = 550.0\n[limits]\nmax_kpa = 300\nmax_rate_kpa_s = 50.0\n\
                    [boards.1.channels.2.limits]\nmax_kpa = 120.5\n";
        let rig = Rig::parse("rig.toml", text).unwrap();
        assert_eq!(rig.highest_set_point_kpa, Some(120.5));
        assert_eq!(rig.supply.unwrap().pressure_kpa, 550.0);
        assert_eq!(
            Rig::parse("rig.toml", "[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.84\n")
                .unwrap()
                .highest_set_point_kpa,
            None
        );
        let refused = Rig::parse("rig.toml", "[limits]\nmax_kpa = -1.0\n").unwrap_err().to_string();
        assert!(refused.contains("limits.max_kpa"), "{refused}");
    }
}
