//! Readings that jump from row to row nearly all the time.

use crate::diagnosis::channel::ChannelData;

/// A sensor's noise is a smaller part of the range in which the pressure moves.
const PART_OF_RANGE: f64 = 0.05;

/// What is taken for noise where a pressure never rests long enough to tell.
pub fn restless(data: &ChannelData) -> Option<String> {
    let usable = data.inputs.measured_pa.iter().zip(data.inputs.usable.iter()).filter(|(_, usable)| **usable);
    let (low, high) =
        usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (p, _)| (l.min(*p), h.max(*p)));
    let part = data.noise_kpa / (1e-3 * (high - low));
    (part > PART_OF_RANGE).then(|| {
        format!(
            "{}: the readings jump by {:.1} kPa from row to row, {:.0} % of their range, and this counts as noise: little else can be seen. Where a loop or a tube swings, record at a higher rate, or hold the commands for longer.",
            data.id,
            data.noise_kpa,
            100.0 * part
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    #[test]
    fn a_pressure_that_never_rests_is_remarked_and_a_sensors_noise_is_not() {
        let (mut data, _) = channel(false);
        data.inputs.measured_pa =
            (0..data.inputs.rows()).map(|k| 2e5 + 100e3 * (0.1 * k as f64).sin()).collect();
        data.noise_kpa = 0.5;
        assert_eq!(restless(&data), None);
        data.noise_kpa = 50.0;
        let said = restless(&data).expect("a quarter of the range");
        assert!(
            said.starts_with("b0c0: the readings jump by 50.0 kPa from row to row, 25 % of their range"),
            "{said}"
        );
    }
}
