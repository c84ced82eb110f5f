//! The figures of one channel: what was commanded, how closely it was followed, and what is
//! missing.

use serde::Serialize;

use crate::data::{Channel, ChannelId, Flags, Recording};

/// A set point that has not moved for so long counts as settled, s: longer than any regulator here
/// takes.
const SETTLED_AFTER_S: f64 = 1.0;

/// Figures of one channel. Deviations are measured minus commanded, of samples that may be used.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelFigures {
    /// Which one.
    pub channel: ChannelId,
    /// Lowest and highest set point, kPa gauge.
    pub command_kpa: Option<[f64; 2]>,
    /// Lowest and highest usable measured pressure, kPa gauge.
    pub pressure_kpa: Option<[f64; 2]>,
    /// Root mean square deviation, kPa; `None` without set points or pressures.
    pub deviation_rms_kpa: Option<f64>,
    /// Deviation of the largest size, kPa, with its sign.
    pub deviation_largest_kpa: Option<f64>,
    /// Mean deviation once the set point has stood still for 1 s, kPa; `None` where it never does.
    pub settled_mean_kpa: Option<f64>,
    /// Root mean square deviation then, kPa.
    pub settled_rms_kpa: Option<f64>,
    /// Rows without a measured pressure: exchanges that were lost.
    pub missing: usize,
    /// Rows whose pressure is there and not to be used: stuck, or at the sensor's limit.
    pub masked: usize,
}

/// The figures of every channel, in the recording's order.
#[must_use]
pub fn figures(recording: &Recording) -> Vec<ChannelFigures> {
    recording.channels.iter().map(|channel| of(recording, channel)).collect()
}

/// Measured minus commanded, row by row, kPa; NaN where either is missing or not to be used. Empty
/// without one of the columns.
pub(super) fn deviations(channel: &Channel) -> Vec<f64> {
    let (Some(command), Some(pressure)) = (&channel.command_kpa, &channel.pressure_kpa) else {
        return Vec::new();
    };
    let rows = command.iter().zip(pressure).zip(&channel.flags);
    rows.map(|((set, measured), flags)| match flags.pressure_usable() {
        true => f64::from(*measured) - f64::from(*set),
        false => f64::NAN,
    })
    .collect()
}

fn of(recording: &Recording, channel: &Channel) -> ChannelFigures {
    let deviations = deviations(channel);
    let settled = settled(recording, channel);
    let settled = deviations.iter().zip(&settled).filter(|(_, settled)| **settled).map(|(d, _)| *d);
    let settled: Vec<f64> = settled.filter(|d| d.is_finite()).collect();
    let finite: Vec<f64> = deviations.into_iter().filter(|d| d.is_finite()).collect();
    let usable = |values: &Option<Vec<f32>>| {
        let values = values.as_ref()?;
        range(values.iter().zip(&channel.flags).filter(|(_, f)| f.pressure_usable()).map(|(v, _)| *v))
    };
    let missing = channel.flags.iter().filter(|flags| flags.contains(Flags::PRESSURE_MISSING)).count();
    let unusable = channel.flags.iter().filter(|flags| !flags.pressure_usable()).count();
    ChannelFigures {
        channel: channel.id,
        command_kpa: channel.command_kpa.as_ref().and_then(|values| range(values.iter().copied())),
        pressure_kpa: usable(&channel.pressure_kpa),
        deviation_rms_kpa: rms(&finite),
        deviation_largest_kpa: finite.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())),
        settled_mean_kpa: mean(&settled),
        settled_rms_kpa: rms(&settled),
        missing,
        masked: unusable - missing,
    }
}

/// Rows at which the set point has stood still for long enough, in one stretch without missing
/// time.
fn settled(recording: &Recording, channel: &Channel) -> Vec<bool> {
    let Some(command) = &channel.command_kpa else { return Vec::new() };
    let mut settled = vec![false; command.len()];
    for segment in recording.segments() {
        let mut since = segment.start;
        for row in segment {
            if command[row].to_bits() != command[since].to_bits() {
                since = row;
            }
            settled[row] = recording.time_s[row] - recording.time_s[since] >= SETTLED_AFTER_S;
        }
    }
    settled
}

fn range(values: impl Iterator<Item = f32>) -> Option<[f64; 2]> {
    let finite = values.map(f64::from).filter(|value| value.is_finite());
    finite.fold(None, |range, value| match range {
        None => Some([value, value]),
        Some([low, high]) => Some([low.min(value), high.max(value)]),
    })
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn rms(values: &[f64]) -> Option<f64> {
    let squares: Vec<f64> = values.iter().map(|value| value * value).collect();
    mean(&squares).map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{LoadOptions, read};

    /// 10 Hz; the set point goes from 0 to 100 kPa at 2 s, and the pressure is 1 kPa above it but
    /// for one sample, which is missing.
    fn recording() -> Recording {
        let row = |k: i32| {
            let set = if k < 20 { 0 } else { 100 };
            let measured = if k == 25 { String::new() } else { format!("{}", set + 1 + k % 2) };
            format!("{},{set},{measured}\n", f64::from(k) * 0.1)
        };
        let text = format!("t_s,b0_cmd0_kpa,b0_p0_kpa\n{}", (0..50).map(row).collect::<String>());
        read("test.csv", text.as_bytes(), LoadOptions::default()).unwrap().recording
    }

    #[test]
    fn deviations_are_measured_minus_commanded() {
        let found = &figures(&recording())[0];
        assert_eq!(found.command_kpa, Some([0.0, 100.0]));
        assert_eq!(found.pressure_kpa, Some([1.0, 102.0]));
        assert_eq!((found.missing, found.masked), (1, 0));
        assert_eq!(found.deviation_largest_kpa, Some(2.0));
        // Half of the samples are 1 kPa off, half 2 kPa; the missing one was to be 2 kPa off.
        let expected = ((25.0 + 24.0 * 4.0) / 49.0_f64).sqrt();
        assert!((found.deviation_rms_kpa.unwrap() - expected).abs() < 1e-6);
    }

    #[test]
    fn settled_begins_a_second_after_the_step() {
        let recording = recording();
        let rows = settled(&recording, &recording.channels[0]);
        assert!(!rows[9] && rows[11] && !rows[20] && !rows[28] && rows[31]);
    }
}
