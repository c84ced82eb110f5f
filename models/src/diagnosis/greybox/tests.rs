use super::filter::{filtered, innovations};
use super::naming::name;
use super::starts::effect_starts;
use super::steered::steered_errors;
use super::uncertainty::Uncertainty;
use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::estimation::plain_costs;
use crate::diagnosis::settings::SETTINGS;
use crate::diagnosis::testing::{channel, normals, with};
use crate::effects::catalogue::{CATALOGUE, index_of};

const NOISE_PA: f64 = 300.0;

/// A channel that measures a model with noise and with a slow deviation of this size, Pa, in every
/// row.
fn recorded(
    model: impl Fn(&ChannelData, &Extended) -> Extended,
    deviation_pa: f64,
) -> (ChannelData, Extended) {
    let (mut data, base) = channel(false);
    let truth = model(&data, &base);
    let rows = data.inputs.rows();
    let (noise, pushes) = (normals(5, rows), normals(6, rows));
    let keep = (-0.01 / SETTINGS.greybox_discrepancy_s).exp();
    let mut slow = 0.0;
    let measured = data.trace(&truth).into_iter().zip(noise).zip(pushes).map(|((row, noise), push)| {
        slow = keep * slow + (1.0 - keep * keep).sqrt() * push;
        row[0] * 1e3 + data.inputs.ambient_pa + NOISE_PA * noise + deviation_pa * slow
    });
    data.inputs.measured_pa = measured.collect();
    let kpa = |row: &u32| (data.inputs.measured_pa[*row as usize] - data.inputs.ambient_pa) * 1e-3;
    data.measured_kpa = data.rows.iter().map(kpa).collect();
    (data, truth)
}

fn all_rows(data: &ChannelData) -> Vec<bool> {
    vec![true; data.inputs.rows()]
}

#[test]
fn errors_of_the_true_model_are_white_and_as_large_as_expected() {
    for (id, values) in
        [("wall_compliance", &[0.0][..]), ("sensor_lag", &[0.03]), ("line_restriction", &[0.1, 0.05, 5.0])]
    {
        for deviation_pa in [30.0, 900.0] {
            let (data, truth) = recorded(|data, base| with(data, base, id, values), deviation_pa);
            let uncertainty = Uncertainty { supply: 1e-5, discrepancy_pa: deviation_pa, noise_pa: NOISE_PA };
            let found = innovations(&data, &truth, &uncertainty, &all_rows(&data));
            let z: Vec<f64> =
                found.errors.iter().zip(&found.variances).map(|(e, v)| e / v.sqrt()).skip(50).collect();
            let n = z.len() as f64;
            let square = z.iter().map(|z| z * z).sum::<f64>() / n;
            let next = z.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
            // Three standard errors of each.
            assert!((square - 1.0).abs() < 3.0 * (2.0 / n).sqrt(), "{id} {deviation_pa}: {square}");
            assert!(next.abs() < 3.0 / n.sqrt(), "{id} {deviation_pa}: {next}");
        }
    }
}

#[test]
fn rows_that_do_not_count_steer_and_rows_that_are_missing_do_not() {
    let (mut data, truth) = recorded(|_, base| base.clone(), 600.0);
    let uncertainty = Uncertainty { supply: 1e-3, discrepancy_pa: 600.0, noise_pa: NOISE_PA };
    let all = innovations(&data, &truth, &uncertainty, &all_rows(&data));
    let mut some = all_rows(&data);
    some[500..600].fill(false);
    let fewer = innovations(&data, &truth, &uncertainty, &some);
    assert_eq!(fewer.errors.len(), all.errors.len() - 100);
    assert_eq!(fewer.errors[499..], all.errors[599..]);
    let mut usable = data.inputs.usable.to_vec();
    usable[500..600].fill(false);
    data.inputs.usable = usable.into();
    let blind = innovations(&data, &truth, &uncertainty, &all_rows(&data));
    assert_eq!(blind.errors.len(), fewer.errors.len());
    // After a second without measurements the deviation is as unknown as at a start.
    assert!(
        blind.variances[499] > 1.2 * all.variances[599],
        "{} {}",
        blind.variances[499],
        all.variances[599]
    );
}

#[test]
fn a_simulation_that_runs_away_says_so() {
    let (data, mut truth) = recorded(|_, base| base.clone(), 100.0);
    truth.values[2] = f64::NAN;
    let uncertainty = Uncertainty { supply: 1e-3, discrepancy_pa: 100.0, noise_pa: NOISE_PA };
    let found = innovations(&data, &truth, &uncertainty, &all_rows(&data));
    assert!(found.errors.last().is_some_and(|e| e.is_nan()));
}

/// A recording with gaps in what is usable and counted, a second start, and the model with a tube.
fn with_gaps() -> (ChannelData, Extended, Vec<bool>) {
    let (mut data, truth) =
        recorded(|data, base| with(data, base, "line_restriction", &[0.1, 0.05, 5.0]), 300.0);
    let mut usable = data.inputs.usable.to_vec();
    usable[300..320].fill(false);
    data.inputs.usable = usable.into();
    data.inputs.starts = [0, 700].into();
    let mut counted = all_rows(&data);
    counted[500..600].fill(false);
    (data, truth, counted)
}

const UNCERTAINTY: Uncertainty = Uncertainty { supply: 1e-3, discrepancy_pa: 300.0, noise_pa: NOISE_PA };

#[test]
fn with_the_gains_of_a_filter_its_model_has_the_errors_of_the_filter() {
    let (data, truth, counted) = with_gaps();
    let (found, gains) = filtered(&data, &truth, &UNCERTAINTY, &counted);
    let mut other = truth.clone();
    other.values[2] *= 1.3;
    let models = [other.clone(), truth.clone(), other];
    let errors = steered_errors(&data, &models, &gains, &counted);
    assert_eq!(errors[1].len(), found.errors.len());
    let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest(&errors[1], &found.errors) < 1e-6, "{} Pa", largest(&errors[1], &found.errors));
    assert_eq!(errors[0], errors[2]);
    assert!(largest(&errors[0], &found.errors) > 100.0, "another valve makes no difference");
}

#[test]
fn slopes_with_given_gains_are_nearly_those_of_the_filter() {
    // Where a tube turns turbulent matters little to the errors, and the gain's part is larger.
    const TURBULENT: usize = 9;
    let (mut data, truth, counted) = with_gaps();
    // Steps that resolve the tube's own volume: in longer ones the gain depends on the step, too.
    data.plant.longest_step_s = 0.005;
    let (found, gains) = filtered(&data, &truth, &UNCERTAINTY, &counted);
    // The volume does not change here, and what weighs its rate does nothing.
    let still = data.plant.position("volume_weight").unwrap();
    for position in (0..truth.values.len()).filter(|&position| position != still) {
        let mut moved = truth.clone();
        let step = 1e-4 * truth.values[position].abs().max(1e-2);
        moved.values[position] += step;
        let by_filter = innovations(&data, &moved, &UNCERTAINTY, &counted).errors;
        let by_gains = steered_errors(&data, &[moved], &gains, &counted).remove(0);
        let slopes = |errors: &[f64]| -> Vec<f64> {
            errors.iter().zip(&found.errors).map(|(a, b)| (a - b) / step).collect()
        };
        let square = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>();
        let [exact, given] = [by_filter, by_gains].map(|errors| slopes(&errors));
        let apart = square(&mut exact.iter().zip(&given).map(|(a, b)| a - b));
        let share = (apart / square(&mut exact.iter().copied())).sqrt();
        let most = if position == TURBULENT { 0.1 } else { 0.02 };
        assert!(share < most, "parameter {position}: {share}");
    }
}

fn numbers(ids: &[&str]) -> Vec<usize> {
    ids.iter().map(|id| index_of(id).expect("it is in the catalogue")).collect()
}

/// What is named of these effects, and its sizes.
fn named_of(data: ChannelData, effects: &[usize]) -> Option<(&'static str, Vec<f64>)> {
    let channels = [data];
    let (_, known) = channel(false);
    let named = name(&channels, &[known], effects, &|| ()).expect("the base model runs");
    named.effect.map(|found| {
        let range = found.models[0].range(&channels[0].plant, found.effect).expect("it acts");
        (CATALOGUE[found.effect].id, found.models[0].values[range].to_vec())
    })
}

#[test]
fn what_is_missing_is_named_though_something_else_is_missing_too() {
    let all: Vec<usize> = (0..CATALOGUE.len()).collect();
    let rivals =
        numbers(&["valve_lag", "transport_delay", "sensor_lag", "valve_hysteresis", "valve_stiction"]);
    for (id, values, among) in
        [("line_restriction", &[0.3, 0.1, 0.0][..], all), ("valve_lag", &[0.05], rivals)]
    {
        let (data, _) = recorded(|data, base| with(data, base, id, values), 600.0);
        let (found, sizes) = named_of(data, &among).expect("it stands out");
        assert_eq!(found, id);
        assert!((sizes[0] / values[0] - 1.0).abs() < 0.2, "{id}: {sizes:?}");
    }
}

#[test]
fn nothing_is_named_where_only_something_slow_and_nameless_is_missing() {
    let (data, _) = recorded(|_, base| base.clone(), 1500.0);
    assert_eq!(named_of(data, &(0..CATALOGUE.len()).collect::<Vec<_>>()), None);
}

#[test]
fn test_blocks_are_not_looked_at() {
    let (mut data, _) = recorded(|data, base| with(data, base, "valve_lag", &[0.05]), 300.0);
    let effects = numbers(&["valve_lag", "transport_delay", "sensor_lag"]);
    let before = named_of(data.clone(), &effects);
    assert_eq!(before.as_ref().map(|named| named.0), Some("valve_lag"));
    // What the test blocks hold steers the filter, and must not decide: here it is another
    // recording altogether.
    let mut measured = data.inputs.measured_pa.to_vec();
    for block in data.blocks.iter().filter(|block| block.role == Role::Test) {
        measured[block.start..block.end].iter_mut().for_each(|p| *p += 2e3);
    }
    data.inputs.measured_pa = measured.into();
    assert_eq!(named_of(data, &effects).map(|n| n.0), before.map(|n| n.0));
}

#[test]
fn beside_an_effect_the_valve_need_not_be_one_that_imitates_it() {
    let (data, truth) = recorded(|data, base| with(data, base, "line_restriction", &[0.7, 0.06, 5.0]), 30.0);
    let mut astray = Extended::base(truth.values[..data.plant.parameters().len()].to_vec());
    for (name, value) in [("gain", 35.0), ("leak_in", 8.0), ("leak_out", 20.0), ("corner", 10.0)] {
        astray.values[data.plant.position(name).unwrap()] = value;
    }
    let starts = effect_starts(&data, &astray, index_of("line_restriction").unwrap());
    let costs = plain_costs(&data, &starts);
    let (best, _) = starts.iter().zip(&costs).min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    let ratio = best.values[data.plant.position("gain").unwrap()] / truth.values[2];
    assert!((0.4..2.5).contains(&ratio), "a valve of {ratio} times the right gain");
}
