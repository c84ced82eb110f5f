//! What an estimate takes for known and is not: the rig file's volume and supply, the flows, and
//! all that sound rigs have of effects that the model does not have.
//!
//! Blocks do not tell of an error that is the same in all of them. So each of these quantities gets
//! a prior deviation, what it does to the readings is simulated, and the recording is asked how
//! much of it there can be beside the parameters: it is fitted along, held by its prior, and what
//! that adds to a parameter's variance is kept. Such quantities are called considered, as against
//! estimated (Schmidt, Advances in Control Systems 3, 1966; Tapley, Schutz and Born, Statistical
//! Orbit Determination, 2004, chapter 6).

use crate::diagnosis::settings::SETTINGS;
use nalgebra::{DMatrix, DVector};

use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::{DISTURBANCES, FLOWS, WANDERS, wander};
use crate::diagnosis::screening::{Probing, applicable};
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{EffectInfo, EffectParameter, Question, Series};

/// A change of the readings by less than this many standard deviations of the noise, over all rows,
/// is none.
const NOTHING: f64 = 1e-6;
/// What sound rigs have of an effect, over the largest usual size, which is two standard
/// deviations.
const USUAL: f64 = 0.5;

/// What the quantities add to the variance of every free parameter, on its scale. `ratio` is the
/// variance of parameters over that from independent residuals of the noise's variance.
#[must_use]
pub fn considered(data: &ChannelData, stage: &ChannelStage, ratio: f64) -> Vec<f64> {
    let mut changes = rig(data, stage);
    changes.extend(flows(data, stage));
    changes.extend(effects(data, stage));
    changes.retain(|change| change.iter().all(|v| v.is_finite()));
    let rows: Vec<usize> = data
        .blocks
        .iter()
        .zip(&data.spans)
        .filter(|(block, _)| block.role == Role::Fit)
        .flat_map(|(_, span)| span.clone())
        .collect();
    let n = stage.free.len();
    let slopes = DMatrix::from_fn(rows.len(), n, |r, k| stage.sensitivities[rows[r] * n + k]);
    let changes: Vec<DVector<f64>> = changes
        .iter()
        .map(|change| DVector::from_fn(rows.len(), |r, _| change[rows[r]]))
        .filter(|change| change.norm() > NOTHING)
        .collect();
    added(&slopes, &changes, SETTINGS.misfit * SETTINGS.misfit * ratio.max(1.0))
        .unwrap_or_else(|| vec![0.0; n])
}

/// Variances of parameters with these `slopes` beside quantities of unit variance that do these
/// `changes`, less those without them, where the residual has this `variance`.
fn added(slopes: &DMatrix<f64>, changes: &[DVector<f64>], variance: f64) -> Option<Vec<f64>> {
    let n = slopes.ncols();
    let mut all = slopes.clone().resize_horizontally(n + changes.len(), 0.0);
    for (k, change) in changes.iter().enumerate() {
        all.set_column(n + k, change);
    }
    let mut information = all.tr_mul(&all) / variance;
    let alone = inverse(&information.view((0, 0), (n, n)).into_owned())?;
    for k in n..information.nrows() {
        information[(k, k)] += 1.0;
    }
    let beside = inverse(&information)?;
    Some((0..n).map(|k| (beside[(k, k)] - alone[(k, k)]).max(0.0)).collect())
}

/// The inverse of an information matrix, whose parameters may be of any size; that of one without
/// influence is large.
fn inverse(information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = information.nrows();
    let scale = DVector::from_fn(n, |k, _| information[(k, k)].max(1e-30).sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |a, b| information[(a, b)] * scale[a] * scale[b]);
    let inverse = (scaled + DMatrix::identity(n, n) * 1e-10).try_inverse()?;
    Some(DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * scale[a] * scale[b]))
}

/// What a larger volume and, where the rig file states it, a higher supply do to the whitened
/// readings.
fn rig(data: &ChannelData, stage: &ChannelStage) -> Vec<Vec<f64>> {
    let inputs = &data.inputs;
    let times = |series: &Series, factor: f64| series.iter().map(|v| v * factor).collect::<Series>();
    let mut larger = data.clone();
    larger.inputs.volume_m3 = times(&inputs.volume_m3, 1.0 + SETTINGS.known_volume);
    larger.inputs.volume_rate_m3_s = times(&inputs.volume_rate_m3_s, 1.0 + SETTINGS.known_volume);
    let mut others = vec![larger];
    let stated = inputs.supply_pa.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits());
    if stated {
        let raised = |p: &f64| inputs.ambient_pa + (p - inputs.ambient_pa) * (1.0 + SETTINGS.known_supply);
        let mut higher = data.clone();
        higher.inputs.supply_pa = inputs.supply_pa.iter().map(raised).collect();
        others.push(higher);
    }
    let probing = Probing::new(data, stage);
    others.iter().map(|other| probing.change_of(other)).collect()
}

/// The same of flows that are off in all blocks alike.
fn flows(data: &ChannelData, stage: &ChannelStage) -> Vec<Vec<f64>> {
    let deviations: Vec<[f64; WANDERS]> = data.disturbances(&stage.model).iter().map(wander).collect();
    let of = |k: usize| {
        let mut change: Vec<f64> = deviations.iter().map(|d| d[k] / data.noise_kpa).collect();
        stage.whitening.apply(&mut change);
        change
    };
    (DISTURBANCES - 1 - FLOWS..DISTURBANCES - 1).map(of).collect()
}

/// The same of effects that the model does not have.
fn effects(data: &ChannelData, stage: &ChannelStage) -> Vec<Vec<f64>> {
    let absent = |effect: &usize| {
        applicable(data, *effect, Question::Structure) && !stage.model.effects.contains(effect)
    };
    let probing = Probing::new(data, stage);
    let of = |effect: usize| {
        let with = |size: Vec<f64>| stage.model.with(&data.plant, effect, &size);
        let models: Vec<Extended> = usual_sizes(data, CATALOGUE[effect]).into_iter().map(with).collect();
        probing.changes(effect, &models)
    };
    let half = |change: Vec<f64>| change.into_iter().map(|v| v * USUAL).collect();
    (0..CATALOGUE.len()).filter(absent).flat_map(of).map(half).collect()
}

/// Sizes of an effect that sound rigs have: the largest ones, and what is not noticed.
fn usual_sizes(data: &ChannelData, info: &EffectInfo) -> Vec<Vec<f64>> {
    let volumes = &data.inputs.volume_m3;
    let mean_m3 = volumes.iter().sum::<f64>() / volumes.len().max(1) as f64;
    let mut sizes = largest_usual(info);
    sizes.extend(info.unnoticed(mean_m3));
    sizes
}

/// Parameters of an effect at the end of what is usual, with each of the probes' values for those
/// of which nothing says what that is: a tube of whatever volume. None where nothing says it of
/// any.
fn largest_usual(info: &EffectInfo) -> Vec<Vec<f64>> {
    if info.parameters.iter().all(|p| !p.usual.is_finite()) {
        return Vec::new();
    }
    let end = |p: &EffectParameter| {
        let (low, high) = p.bounds(true);
        if high > p.null { high } else { low }
    };
    let size = |probe: &[f64]| -> Vec<f64> {
        let told = probe.iter().zip(info.parameters);
        told.map(|(value, p)| if p.usual.is_finite() { end(p) } else { *value }).collect()
    };
    let mut sizes: Vec<Vec<f64>> = Vec::new();
    for probe in info.probes {
        let size = size(probe);
        if !sizes.contains(&size) {
            sizes.push(size);
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;
    use crate::effects::catalogue::index_of;

    fn slopes() -> DMatrix<f64> {
        DMatrix::from_column_slice(4, 1, &[2.0, 0.0, 0.0, 0.0])
    }

    fn added_by(change: [f64; 4]) -> f64 {
        added(&slopes(), &[DVector::from_column_slice(&change)], 0.01).map_or(f64::NAN, |v| v[0])
    }

    #[test]
    fn a_usual_tube_may_be_of_any_volume_and_a_ratio_of_gains_is_off_in_one_way() {
        let (data, _) = channel(false);
        let of = |id: &str| usual_sizes(&data, CATALOGUE[index_of(id).unwrap()]);
        let tubes = of("line_restriction");
        let is = |time_constant_s: f64, ratio: f64| {
            let near = |size: &Vec<f64>| {
                (size[0] / time_constant_s - 1.0).abs() < 0.01 && (size[1] / ratio - 1.0).abs() < 0.01
            };
            tubes.iter().any(near)
        };
        assert!(is(0.06, 0.02) && is(0.06, 0.1), "{tubes:?}");
        // 56.5 ml of tube before 300 ml of chamber.
        assert!(is(0.003, 0.1885), "{tubes:?}");
        assert_eq!(of("valve_asymmetry").len(), 1);
        assert!(of("stale_samples").is_empty(), "nothing says how many a sound rig has");
    }

    #[test]
    fn what_looks_like_the_parameter_makes_it_as_uncertain_as_itself() {
        // Its deviation moves the readings as 1.5 of the parameter does, and nothing tells the two
        // apart.
        assert!((added_by([3.0, 0.0, 0.0, 0.0]) - 2.25).abs() < 1e-4);
    }

    #[test]
    fn what_the_recording_shows_by_itself_adds_little() {
        let told = added_by([3.0, 3.0, 0.0, 0.0]);
        // A residual of 0.1 tells it to 0.1 / 3 of its deviation.
        assert!((told - 2.25 / (1.0 + 900.0)).abs() < 1e-4, "{told}");
        assert!(added_by([0.0, 3.0, 0.0, 0.0]).abs() < 1e-9);
    }
}
