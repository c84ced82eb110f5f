//! Whether a cause has earned its name beside a larger one.
//!
//! No cause is described to the last digit. What a large one leaves is small and has a shape, and
//! some effect of the catalogue always fits a part of that.

use crate::diagnosis::json::{Cause, Imperfection, Unnamed};
use crate::diagnosis::selection::roughly_timed;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::{CATALOGUE, index_of};

use super::earned::{hunts, may_be_nothing, stands_out};

/// Parts causes, the largest gain first, into those that keep their names beside each other and
/// those that do not. `base_kpa` is the error of the base models on the test blocks. In closed loop
/// (`looped`) what by all its sizes may be nothing has no name beside what may not. With the drive,
/// a gain need not be sure where the cause itself is: larger than in sound rigs, and `probable`.
#[must_use]
pub fn part(
    causes: Vec<Cause>,
    base_kpa: f64,
    looped: bool,
    probable: impl Fn(&Cause) -> bool,
) -> (Vec<Cause>, Vec<Imperfection>) {
    let (mut named, mut imperfections) = (causes, Vec::new());
    let sized = |cause: &Cause| hunts(cause) || !may_be_nothing(cause);
    if looped && named.iter().any(sized) {
        imperfections.extend(unnamed(&mut named, Unnamed::Undetermined, |_, cause| sized(cause)));
    }
    // Rollouts of a loop go astray beside what happens at times that the rows tell only roughly:
    // there gains are never sure.
    if !(looped && named.iter().any(happens_roughly)) {
        let told = |cause: &Cause| {
            !looped && is_large(cause) && probable(cause) && cause.gain.reduction > SETTINGS.practical
        };
        let keeps = |place, cause: &Cause| place == 0 || is_sure_beside(cause, base_kpa) || told(cause);
        imperfections.extend(unnamed(&mut named, Unnamed::Gainless, keeps));
    }
    (named, imperfections)
}

/// Takes those that do not keep their names, told by their place and themselves, out of the causes.
fn unnamed(
    causes: &mut Vec<Cause>,
    why: Unnamed,
    keeps: impl Fn(usize, &Cause) -> bool,
) -> Vec<Imperfection> {
    let (mut named, mut others) = (Vec::new(), Vec::new());
    for (place, cause) in std::mem::take(causes).into_iter().enumerate() {
        if keeps(place, &cause) { named.push(cause) } else { others.push(Imperfection { why, cause }) }
    }
    *causes = named;
    others
}

/// Is the gain surely worth a name, and also counted against the error that was there at first?
fn is_sure_beside(cause: &Cause, base_kpa: f64) -> bool {
    let gain = &cause.gain;
    let taken_kpa = gain.test_rmse_before_kpa - gain.test_rmse_after_kpa;
    let hidden = gain.ci95[0] <= SETTINGS.practical;
    let sure = !hidden || gain.weighted_ci95[0] > SETTINGS.practical;
    // Of what drifts hide, kilopascals do not tell how much it is.
    sure && (hidden || taken_kpa >= SETTINGS.practical * base_kpa)
}

/// Is its size, with the whole interval, beyond what sound rigs have?
fn is_large(cause: &Cause) -> bool {
    index_of(&cause.effect).is_some_and(|k| stands_out(CATALOGUE[k], &cause.parameters, false))
}

fn happens_roughly(cause: &Cause) -> bool {
    index_of(&cause.effect).is_some_and(roughly_timed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{self, sized};

    /// What keeps its name.
    fn named(causes: Vec<Cause>, base_kpa: f64, looped: bool) -> Vec<String> {
        part(causes, base_kpa, looped, |_| false).0.into_iter().map(|cause| cause.effect).collect()
    }

    /// Behind a tube, play with a gain of 5 % in either weighing, whose interval begins there.
    fn play_behind_a_tube(plain: f64, weighted: f64, base_kpa: f64, looped: bool) -> usize {
        let gain = testing::cause("line_restriction", 0.9).gain;
        let tube = Cause { gain, ..sized("line_restriction", "time_constant", [0.2, 0.3]) };
        let gain = testing::cause("valve_hysteresis", 0.05).gain;
        let mut play = Cause { gain, ..sized("valve_hysteresis", "half_width", [0.02, 0.03]) };
        (play.gain.ci95[0], play.gain.weighted_ci95[0]) = (plain, weighted);
        named(vec![tube, play], base_kpa, looped).len()
    }

    #[test]
    fn a_further_name_needs_a_gain_that_is_sure() {
        for looped in [false, true] {
            assert_eq!(play_behind_a_tube(0.02, -0.1, 2.0, looped), 2);
            assert_eq!(play_behind_a_tube(-0.1, 0.02, 2.0, looped), 2);
            assert_eq!(play_behind_a_tube(0.005, 0.005, 2.0, looped), 1);
        }
    }

    #[test]
    fn a_further_name_takes_a_hundredth_of_the_error_that_was_there_at_first() {
        assert_eq!(play_behind_a_tube(0.02, 0.02, 9.0, true), 2);
        assert_eq!(play_behind_a_tube(0.02, 0.02, 11.0, true), 1);
        assert_eq!(play_behind_a_tube(-0.1, 0.02, 11.0, true), 2, "drifts hide how much that is");
    }

    #[test]
    fn with_the_drive_a_large_and_probable_cause_needs_no_sure_gain() {
        let kept = |range: [f64; 2], (looped, probable): (bool, bool), reduction: f64| {
            let first = testing::cause("valve_asymmetry", 0.9);
            let mut sag = sized("supply_sag", "drop", range);
            (sag.gain.reduction, sag.gain.ci95[0], sag.gain.weighted_ci95[0]) = (reduction, -0.5, -0.1);
            part(vec![first, sag], 2.0, looped, |_| probable).0.len() == 2
        };
        assert!(kept([45.0, 71.0], (false, true), 0.2));
        assert!(!kept([45.0, 71.0], (true, true), 0.2), "of a loop the error hardly tells");
        assert!(!kept([45.0, 71.0], (false, false), 0.2), "something else is as probable");
        assert!(!kept([0.0, 71.0], (false, true), 0.2), "a sound rig may have as much");
        assert!(!kept([45.0, 71.0], (false, true), -0.1), "it takes nothing of the error");
    }

    #[test]
    fn the_first_name_may_have_a_gain_that_is_not_sure() {
        let mut first = testing::cause("valve_hysteresis", 0.05);
        first.gain.ci95[0] = -0.1;
        assert_eq!(named(vec![first], 20.0, true).len(), 1);
    }

    #[test]
    fn beside_stale_samples_in_a_loop_no_gain_is_sure() {
        let found = || {
            let mut heat = sized("heat_exchange", "time_constant", [0.4, 0.6]);
            heat.gain.ci95[0] = -0.1;
            vec![testing::cause("stale_samples", 0.5), heat]
        };
        assert_eq!((named(found(), 2.0, true).len(), named(found(), 2.0, false).len()), (2, 1));
    }

    #[test]
    fn in_closed_loop_what_has_a_size_leaves_no_name_to_what_may_be_nothing() {
        let limited = || sized("drive_saturation", "limit", [0.68, 0.72]);
        let sagging = |size: Option<[f64; 2]>| {
            let mut sag = sized("supply_sag", "drop", size.unwrap_or_default());
            sag.parameters.values_mut().for_each(|drop| drop.ci95 = size);
            sag
        };
        let (named, unnamed) = part(vec![limited(), sagging(None)], 2.0, true, |_| false);
        assert_eq!((named.len(), named[0].effect.as_str()), (1, "drive_saturation"));
        assert!(unnamed.iter().all(|i| i.why == Unnamed::Undetermined));
        let count = |causes, looped| part(causes, 2.0, looped, |_| false).0.len();
        assert_eq!(count(vec![limited(), sagging(Some([20.0, 70.0]))], true), 2);
        assert_eq!(count(vec![limited(), sagging(Some([0.0, 70.0]))], true), 1, "it may be none");
        assert_eq!(count(vec![limited(), sagging(None)], false), 2, "with the drive, the error tells");
        assert_eq!(count(vec![sagging(None)], true), 1);
    }
}
