//! Pressures that do not go with the supply: most often a column or a rig file in bar.

use super::finding::{Finding, FindingKind};
use crate::{Channel, Flags};

/// A sound rig file is off by some per cent; a pressure that is this much above the supply's is of
/// another unit.
const ABOVE: f64 = 1.25;
/// Chambers are moved through more of the supply than this; a unit of 100 kPa leaves less.
const BELOW: f64 = 0.02;
/// Below this chambers stand vented, and what is measured is noise, kPa.
const VENTED_KPA: f64 = 0.5;

/// Do the measured pressures go with a supply of so many kPa gauge?
pub(crate) fn odd_pressure(channels: &[Channel], supply_kpa: f64) -> Option<Finding> {
    let measured = |channel: &Channel| -> f64 {
        let values = channel.pressure_kpa.iter().flatten();
        // In another unit, all of them may be beyond the sensor's limits.
        let limit = |flags: &Flags| flags.contains(Flags::SATURATED) && !flags.contains(Flags::STUCK);
        let usable = values.zip(&channel.flags).filter(|(_, flags)| flags.pressure_usable() || limit(flags));
        usable.fold(f64::NEG_INFINITY, |highest, (kpa, _)| highest.max(f64::from(*kpa)))
    };
    let highest = channels.iter().map(|channel| (measured(channel), channel.id));
    let (highest_kpa, id) = highest.max_by(|one, other| one.0.total_cmp(&other.0))?;
    let column = id.pressure_column();
    let sentence = if highest_kpa > ABOVE * supply_kpa {
        format!(
            "{column}: {highest_kpa:.1} kPa is measured with a supply of {supply_kpa:.1} kPa in the rig file; is one of them in another unit? 1 kPa is 1000 Pa, and 1 bar 100 kPa: `pneudrive-model import --map {column}=..:Pa` converts a column."
        )
    } else if highest_kpa > VENTED_KPA && highest_kpa < BELOW * supply_kpa {
        format!(
            "{column}: the highest pressure of all is {highest_kpa:.2} kPa, with a supply of {supply_kpa:.1} kPa in the rig file; is one of them in another unit? 1 bar is 100 kPa: `pneudrive-model import --map {column}=..:bar` converts a column."
        )
    } else {
        return None;
    };
    Some(Finding::new(FindingKind::OddPressure, Some(id), 1, Vec::new(), sentence))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ChannelId;

    fn reaching(kpa: f32) -> Channel {
        let id = ChannelId { board: 0, channel: 1 };
        let (pressure_kpa, flags) = (Some(vec![0.0, kpa, f32::NAN]), vec![Flags::NONE; 3]);
        Channel { id, command_kpa: None, pressure_kpa, drive: None, flags }
    }

    #[test]
    fn bar_for_kpa_is_said_in_the_column_and_in_the_rig_file() {
        let said =
            |kpa, supply_kpa| odd_pressure(&[reaching(kpa)], supply_kpa).map(|finding| finding.sentence);
        assert!(said(3.1, 550.0).unwrap().starts_with("b0_p1_kpa: the highest pressure of all is 3.10 kPa"));
        assert!(said(300.0, 5.5).unwrap().contains("300.0 kPa is measured with a supply of 5.5 kPa"));
        // In pascals everything is beyond the sensor's limits.
        let mut beyond = reaching(3e5);
        beyond.flags = vec![Flags::SATURATED; 3];
        let sentence = odd_pressure(&[beyond], 550.0).unwrap().sentence;
        assert!(sentence.contains("1 kPa is 1000 Pa") && sentence.contains("b0_p1_kpa=..:Pa"), "{sentence}");
        // A rig file that is off, a blower, chambers that stay vented, nothing measured.
        for (kpa, supply_kpa) in [(560.0, 550.0), (3.5, 4.0), (0.4, 550.0), (f32::NAN, 550.0)] {
            assert_eq!(said(kpa, supply_kpa), None, "{kpa} of {supply_kpa}");
        }
    }
}
