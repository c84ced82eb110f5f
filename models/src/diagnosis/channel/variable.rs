//! What a residual may depend on, and a function of it as a sum of hats.

use serde::{Deserialize, Serialize};

use crate::effects::{ChannelInputs, Series};

/// Hat functions per variable.
pub const HATS: usize = 6;

/// A variable the residual may depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Variable {
    /// Value of the drive.
    Drive,
    /// Direction in which the drive moves.
    DriveDirection,
    /// Measured pressure.
    Pressure,
    /// Rate of the simulated pressure: the direction of flow.
    FlowDirection,
    /// Rate of the chamber's volume.
    VolumeRate,
    /// Time since the start.
    Time,
    /// Flow that the other channels draw.
    OthersDraw,
    /// Rate of the pressure in the chamber opposite.
    Opposite,
    /// Drive of the channel that the board handles before this one.
    NeighbourDrive,
}

impl Variable {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Drive,
        Self::DriveDirection,
        Self::Pressure,
        Self::FlowDirection,
        Self::VolumeRate,
        Self::Time,
        Self::OthersDraw,
        Self::Opposite,
        Self::NeighbourDrive,
    ];

    /// Completes "the residual depends on".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Drive => "the drive",
            Self::DriveDirection => "the direction in which the drive moves",
            Self::Pressure => "the pressure",
            Self::FlowDirection => "how fast the chamber fills or vents",
            Self::VolumeRate => "how fast the volume changes",
            Self::Time => "the time since the start",
            Self::OthersDraw => "what the other channels draw from the supply",
            Self::Opposite => "the pressure in the chamber opposite",
            Self::NeighbourDrive => "the drive of the channel before",
        }
    }
}

/// The variable at every row; `None` where the recording does not have it or it never changes.
#[must_use]
pub fn series(inputs: &ChannelInputs, trace: &[[f64; 3]], variable: Variable) -> Option<Series> {
    let rows = inputs.rows();
    let drive = |k: usize| trace[k][1];
    let reading = |k: usize| trace[k.min(rows - 1)][0];
    // Direction over about 50 ms.
    let window = ((0.05 * rows as f64 / inputs.duration_s.max(1e-9)).round().max(1.0)) as usize;
    let values: Series = match variable {
        Variable::Drive => (0..rows).map(drive).collect(),
        Variable::DriveDirection => {
            (0..rows).map(|k| (drive(k) - drive(k.saturating_sub(window))).clamp(-0.3, 0.3)).collect()
        }
        Variable::Pressure => (0..rows).map(reading).collect(),
        Variable::FlowDirection => {
            (0..rows).map(|k| (reading(k + 1) - reading(k)) / inputs.interval_s[k]).collect()
        }
        Variable::VolumeRate => (0..rows).map(|k| inputs.volume_rate_m3_s[k] / inputs.volume_m3[k]).collect(),
        Variable::Time => inputs.time_s.clone(),
        Variable::OthersDraw => inputs.others_draw.clone(),
        Variable::NeighbourDrive => inputs.neighbour_drive.clone(),
        Variable::Opposite if inputs.opposite_pa.is_empty() => return None,
        Variable::Opposite => (0..rows)
            .map(|k| {
                let next = inputs.opposite_pa[(k + 1).min(rows - 1)];
                (next - inputs.opposite_pa[k]) / inputs.interval_s[k] * 1e-3
            })
            .collect(),
    };
    let first = values.first().copied()?;
    values.iter().any(|v| (v - first).abs() > 1e-9 * (1.0 + first.abs())).then_some(values)
}

/// Weights of the hats at a value: the two neighbours share it.
#[must_use]
pub fn hats(knots: &[f64], value: f64) -> [f64; HATS] {
    let mut weights = [0.0; HATS];
    let x = value.clamp(knots[0], knots[HATS - 1]);
    let k = knots[1..HATS - 1].partition_point(|knot| *knot <= x);
    let width = (knots[k + 1] - knots[k]).max(1e-12);
    let share = ((x - knots[k]) / width).clamp(0.0, 1.0);
    weights[k] = 1.0 - share;
    weights[k + 1] = share;
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    const KNOTS: [f64; HATS] = [-1.0, -0.5, 0.0, 0.2, 0.4, 1.0];

    #[test]
    fn hats_share_a_value_between_neighbours_and_hold_beyond_the_ends() {
        for k in 0..=60 {
            let value = -1.5 + 0.05 * f64::from(k);
            let weights = hats(&KNOTS, value);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
            let mean: f64 = weights.iter().zip(KNOTS).map(|(w, x)| w * x).sum();
            assert!((mean - value.clamp(-1.0, 1.0)).abs() < 1e-12, "{mean} {value}");
            assert!(weights.iter().filter(|w| **w > 0.0).count() <= 2);
        }
        assert_eq!(hats(&KNOTS, 0.2), [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_variable_that_is_missing_or_never_changes_is_none() {
        let (mut data, model) = channel(false);
        let trace = data.trace(&model);
        assert!(data.series(&trace, Variable::Drive).is_some());
        assert!(data.series(&trace, Variable::Opposite).is_some());
        assert!(data.series(&trace, Variable::NeighbourDrive).is_some());
        // The chamber is rigid.
        assert!(data.series(&trace, Variable::VolumeRate).is_none());
        data.inputs.opposite_pa = Series::default();
        data.inputs.neighbour_drive = Series::default();
        assert!(data.series(&trace, Variable::Opposite).is_none());
        assert!(data.series(&trace, Variable::NeighbourDrive).is_none());
    }
}
