//! Dependences of channels whose truth is known.

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
fn knots_ascend_over_nearly_the_whole_range() {
    // Most values in a small part of it.
    let values: Vec<f64> =
        (0..1000).map(|k| if k < 900 { 1e-4 * f64::from(k) } else { f64::from(k) }).collect();
    let knots = knots(&values);
    assert!(knots.windows(2).all(|pair| pair[0] < pair[1]), "{knots:?}");
    assert!(knots[0] < 0.002 && knots[HATS - 1] > 980.0, "{knots:?}");
}

#[test]
fn a_variable_that_is_missing_or_never_changes_is_none() {
    let (mut data, model) = channel(false);
    let trace = data.trace(&model);
    assert!(series(&data, &trace, Variable::Drive).is_some());
    assert!(series(&data, &trace, Variable::Opposite).is_some());
    // The chamber is rigid, and nobody measured the neighbour's drive.
    assert!(series(&data, &trace, Variable::VolumeRate).is_none());
    assert!(series(&data, &trace, Variable::NeighbourDrive).is_none());
    data.inputs.opposite_pa = Series::default();
    assert!(series(&data, &trace, Variable::Opposite).is_none());
}
