use super::*;
use crate::diagnosis::testing::{self, sized};

fn cause(effect: &str, name: &str, ci95: Option<[f64; 2]>, gain: f64) -> Cause {
    let mut cause = sized(effect, name, ci95.unwrap_or_default());
    cause.parameters.values_mut().for_each(|size| size.ci95 = ci95);
    Cause { gain: testing::cause(effect, gain).gain, ..cause }
}

fn verdict(effect: &str, name: &str, ci95: Option<[f64; 2]>, gain: f64) -> Option<Unnamed> {
    why_not(&cause(effect, name, ci95, gain), false, false)
}

#[test]
fn what_sound_rigs_have_is_no_cause_however_certain() {
    assert_eq!(verdict("valve_asymmetry", "ratio", Some([0.95, 0.96]), 0.4), Some(Unnamed::Usual));
    assert_eq!(verdict("valve_asymmetry", "ratio", Some([0.69, 0.71]), 0.4), None);
    // 0.875 may be 1.
    assert_eq!(verdict("valve_asymmetry", "ratio", Some([0.7, 1.05]), 0.4), Some(Unnamed::Usual));
    assert_eq!(verdict("valve_asymmetry", "ratio", Some([0.8, 0.95]), 0.4), None);
}

#[test]
fn in_a_loop_a_supply_within_its_tolerance_makes_no_suspicious_ratio_of_gains() {
    let asymmetry = CATALOGUE[index_of("valve_asymmetry").unwrap()];
    let ratio = &asymmetry.parameters[0];
    for stated in [0.95, 1.05] {
        let (mut data, base) = testing::channel(true);
        let ambient = data.inputs.ambient_pa;
        let told = data.inputs.supply_pa.iter().map(|p| ambient + stated * (p - ambient)).collect();
        data.inputs.supply_pa = told;
        let fitted = testing::fitted(&data, &testing::with(&data, &base, "valve_asymmetry", &[1.0]));
        let seeming = *fitted.model.values.last().unwrap();
        let distance = ratio.distance(seeming);
        // Most of what is allowed for, and no more.
        assert!((0.5..1.0).contains(&(distance / ratio.seeming_in_loop)), "{stated}: {seeming}");
    }
    let verdict =
        |looped| why_not(&cause("valve_asymmetry", "ratio", Some([0.84, 0.91]), 0.4), false, looped);
    assert_eq!((verdict(false), verdict(true)), (None, Some(Unnamed::Usual)));
}

#[test]
fn one_size_beyond_what_is_usual_is_enough() {
    let mut flow = cause("flow_function", "critical_ratio", Some([0.27, 0.31]), 0.4);
    let exponent = cause("flow_function", "exponent", Some([0.65, 0.7]), 0.4).parameters;
    assert_eq!(why_not(&flow, false, false), None);
    flow.parameters.extend(exponent);
    assert_eq!(why_not(&flow, false, false), None);
    let usual = cause("flow_function", "exponent", Some([0.49, 0.55]), 0.4).parameters;
    flow.parameters.extend(usual);
    assert_eq!(why_not(&flow, false, false), Some(Unnamed::Usual));
}

#[test]
fn what_may_be_nothing_is_no_cause_where_the_loop_hides_what_is_wrong() {
    let sag = |low| cause("supply_sag", "drop", Some([low, 80.0]), 0.4);
    assert_eq!(why_not(&sag(0.0), false, true), Some(Unnamed::Usual));
    assert_eq!(why_not(&sag(10.0), false, true), None);
    assert_eq!(why_not(&sag(0.0), false, false), None);
}

#[test]
fn without_a_gain_there_is_no_name() {
    assert_eq!(verdict("transport_delay", "delay", Some([0.011, 0.013]), 0.005), Some(Unnamed::Gainless));
    assert_eq!(verdict("transport_delay", "delay", Some([0.011, 0.013]), -0.5), Some(Unnamed::Gainless));
    assert_eq!(verdict("transport_delay", "delay", Some([0.011, 0.013]), 0.02), None);
    // Drifts of some kilopascals hide what is certain where they are weighed.
    let mut hidden = cause("transport_delay", "delay", Some([0.011, 0.013]), -0.1);
    hidden.gain.weighted_ci95 = [0.3, 0.5];
    assert_eq!(why_not(&hidden, false, false), None);
}

#[test]
fn what_may_be_nothing_in_size_and_in_gain_has_no_name() {
    let sag = |size: Option<[f64; 2]>, gain: [f64; 2], weighted: f64| {
        let mut cause = cause("supply_sag", "drop", size, 0.3);
        cause.gain.ci95 = gain;
        cause.gain.weighted_ci95 = [weighted, 0.5];
        why_not(&cause, false, false)
    };
    assert_eq!(sag(Some([0.0, 90.0]), [-0.2, 0.5], -0.01), Some(Unnamed::Gainless));
    assert_eq!(sag(None, [-0.2, 0.5], -0.01), Some(Unnamed::Gainless), "a size that is not determined");
    assert_eq!(sag(Some([20.0, 70.0]), [-0.2, 0.5], -0.01), None, "a size that is there");
    assert_eq!(sag(Some([0.0, 90.0]), [0.2, 0.5], -0.01), None, "a gain that is there");
    assert_eq!(sag(Some([0.0, 90.0]), [-0.2, 0.5], 0.05), None, "one that is there where drifts are weighed");
}

#[test]
fn what_makes_a_loop_hunt_needs_no_sure_gain() {
    let mut cause = cause("valve_stiction", "threshold", None, 0.3);
    cause.gain.ci95 = [-0.2, 0.5];
    cause.gain.weighted_ci95 = [-0.4, 0.5];
    assert_eq!(why_not(&cause, false, true), None);
    assert_eq!(why_not(&cause, false, false), Some(Unnamed::Gainless));
}

#[test]
fn a_threshold_that_may_be_none_has_a_name_where_the_likelihood_is_sure_that_a_loop_hunts() {
    let named = |effect: &str, name: &str, size: [f64; 2], weighted: f64| {
        let mut cause = cause(effect, name, Some(size), 0.3);
        cause.gain.weighted_ci95 = [weighted, 0.6];
        why_not(&cause, false, true)
    };
    assert_eq!(named("valve_stiction", "threshold", [0.0, 0.2], 0.14), None);
    assert_eq!(named("valve_stiction", "threshold", [0.0, 0.2], 0.04), Some(Unnamed::Usual));
    assert_eq!(named("valve_stiction", "threshold", [0.0, 0.02], 0.14), Some(Unnamed::Usual), "no more");
    assert_eq!(
        named("valve_hysteresis", "half_width", [0.0, 0.2], 0.14),
        Some(Unnamed::Usual),
        "has a slope"
    );
}

#[test]
fn what_makes_a_loop_hunt_and_rollouts_surely_worse_needs_a_likelihood_that_is_sure() {
    let mut cause = cause("valve_stiction", "threshold", Some([0.05, 0.06]), -0.05);
    cause.gain.weighted_ci95 = [0.02, 0.06];
    cause.gain.ci95 = [-0.07, 0.01];
    assert_eq!(why_not(&cause, false, true), None);
    cause.gain.ci95 = [-0.07, -0.03];
    assert_eq!(why_not(&cause, false, true), Some(Unnamed::Gainless));
    cause.gain.weighted_ci95 = [0.18, 0.25];
    assert_eq!(why_not(&cause, false, true), None);
}

#[test]
fn what_something_that_need_not_be_missing_does_as_well_is_modelled_without_a_name() {
    let found = vec![
        cause("heat_exchange", "time_constant", Some([0.4, 0.6]), 0.7),
        cause("vent_restriction", "area_ratio", Some([1.5, 2.0]), 0.2),
        cause("supply_sag", "drop", Some([20.0, 70.0]), 0.2),
    ];
    let alike = Unearned { imitated: &["vent_restriction"], as_usual: &["supply_sag"] };
    let (causes, imperfections) = part(found, alike, Circumstances::default(), |_| 1.0);
    assert_eq!(causes.iter().map(|c| c.effect.as_str()).collect::<Vec<_>>(), ["heat_exchange"]);
    let why: Vec<_> = imperfections.iter().map(|i| i.why).collect();
    assert_eq!(why, [Unnamed::Imitated, Unnamed::Usual]);
}

#[test]
fn in_closed_loop_a_size_that_sound_rigs_may_have_needs_a_gain_that_is_sure_where_drifts_are_weighed() {
    let sag = |size: Option<[f64; 2]>, weighted: f64, looped: bool| {
        let mut cause = cause("supply_sag", "drop", size, 0.5);
        cause.gain.ci95 = [0.16, 0.97];
        cause.gain.weighted_ci95 = [weighted, 0.6];
        why_not(&cause, false, looped)
    };
    for doubtful in [Some([3.8, 74.0]), None] {
        assert_eq!(sag(doubtful, 0.008, true), Some(Unnamed::Gainless));
        assert_eq!(sag(doubtful, 0.02, true), None);
        assert_eq!(sag(doubtful, 0.008, false), None, "the drive being recorded, the error tells");
    }
    assert_eq!(sag(Some([16.0, 70.0]), 0.008, true), None, "beyond what is usual");
    let mut stale = cause("stale_samples", "share", Some([0.2, 0.3]), 0.5);
    stale.gain.weighted_ci95 = [-0.5, 0.2];
    assert_eq!(why_not(&stale, false, true), None, "nothing is usual");
}

#[test]
fn what_ties_with_several_others_must_be_more_than_more_probable_than_not() {
    let named = |ties: usize, probable: f64, looped: bool| {
        let mut sag = cause("supply_sag", "drop", Some([20.0, 70.0]), 0.4);
        sag.gain.weighted_ci95 = [0.04, 0.5];
        sag.equivalent = ["valve_wear", "wall_creep"].iter().take(ties).map(|id| (*id).to_owned()).collect();
        !part(vec![sag], Unearned::default(), looped_or_not(looped), |_| probable).0.is_empty()
    };
    assert!(named(1, 0.6, true) && !named(2, 0.6, true) && named(2, 0.9, true));
    assert!(named(2, 0.6, false), "the drive being recorded, a size tells");
}

#[test]
fn in_closed_loop_and_without_a_size_that_is_determined_only_what_is_probable_has_a_name() {
    let named_by = |size: Option<[f64; 2]>, looped: bool, probable: bool, weighted: f64| {
        let mut sag = cause("supply_sag", "drop", size, 0.4);
        sag.gain.weighted_ci95 = [weighted, 0.5];
        let (causes, imperfections) =
            part(vec![sag], Unearned::default(), looped_or_not(looped), |_| if probable { 0.6 } else { 0.4 });
        assert!(imperfections.iter().all(|i| i.why == Unnamed::Improbable));
        !causes.is_empty()
    };
    let named = |size, looped, probable| named_by(size, looped, probable, 0.04);
    let determined = Some([20.0, 70.0]);
    assert!(!named(None, true, false) && !named(None, false, false) && !named(determined, true, false));
    assert!(named(None, true, true) && named(None, false, true) && named(determined, true, true));
    assert!(named(determined, false, false), "the drive being recorded, a size tells");
    assert!(named_by(determined, true, false, 0.1), "in closed loop, a size and a gain that are sure");
    assert!(!named_by(None, true, false, 0.1) && !named_by(Some([2.0, 70.0]), true, false, 0.1));
    // Of a loop that hunts, how far says little, and that it hunts says much.
    let found = |size| vec![cause("valve_stiction", "threshold", size, 0.4)];
    let causes =
        |size, looped| part(found(size), Unearned::default(), looped_or_not(looped), |_| 0.4).0.len();
    assert_eq!((causes(None, true), causes(None, false), causes(Some([0.05, 0.07]), true)), (1, 0, 1));
}

#[test]
fn what_is_less_probable_than_is_worth_a_line_has_no_name() {
    let named = |effect: &str, name: &str, looped: bool, probability: f64| {
        let mut found = cause(effect, name, Some([0.05, 0.06]), 0.4);
        found.gain.weighted_ci95 = [0.3, 0.5];
        !part(vec![found], Unearned::default(), looped_or_not(looped), |_| probability).0.is_empty()
    };
    for probability in [2e-7, 0.01] {
        let worth = probability > LEAST_PROBABLE;
        assert_eq!(named("chamber_coupling", "coupling", false, probability), worth, "a size and a gain");
        assert_eq!(named("valve_stiction", "threshold", true, probability), worth, "a loop that hunts");
    }
}

fn looped_or_not(looped: bool) -> Circumstances {
    Circumstances { looped, ..Circumstances::default() }
}

#[test]
fn where_the_base_model_is_adequate_a_name_is_more_probable_than_not_or_sure_by_itself() {
    let named = |adequate: bool, probability: f64, weighted: f64| {
        let mut found = cause("supply_sag", "drop", Some([10.0, 40.0]), 0.4);
        found.gain.weighted_ci95 = [weighted, 0.5];
        let circumstances = Circumstances { adequate, ..Circumstances::default() };
        !part(vec![found], Unearned::default(), circumstances, |_| probability).0.is_empty()
    };
    assert!(named(false, 0.12, 0.02) && !named(true, 0.12, 0.02));
    assert!(named(true, 0.6, 0.02) && named(true, 0.12, 0.06));
}

#[test]
fn what_is_hardly_probable_has_a_name_only_with_a_gain_that_is_surely_large() {
    let named = |weighted: f64, probability: f64| {
        let mut found = cause("stale_samples", "share", Some([0.05, 0.7]), 0.4);
        found.gain.weighted_ci95 = [weighted, 0.5];
        !part(vec![found], Unearned::default(), Circumstances::default(), |_| probability).0.is_empty()
    };
    assert!(named(0.013, 0.02) && !named(0.013, 0.003) && named(0.06, 0.003));
}

#[test]
fn since_a_calibration_every_size_counts() {
    let small = cause("valve_asymmetry", "ratio", Some([0.95, 0.96]), 0.4);
    assert_eq!(why_not(&small, true, false), None);
}

#[test]
fn a_size_that_is_not_determined_is_not_called_usual() {
    assert_eq!(verdict("valve_asymmetry", "ratio", None, 0.4), None);
}
