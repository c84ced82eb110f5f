//! Whether a cause that was found has earned its name.
//!
//! The search asks which effects make the simulation better by more than chance. With a long
//! recording that is next to everything: valves' curves are never quite those of the model, and
//! some effect of the catalogue always describes a part of it. A name needs more: a size that sound
//! rigs do not have, and a gain on data that nobody fitted to.

use crate::diagnosis::settings::SETTINGS;
use std::collections::BTreeMap;

use crate::diagnosis::json::{Cause, Estimate, Imperfection, Unnamed};
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::effects::{EffectInfo, EffectParameter};

/// Explanations less probable than this are not listed, and no cause among them has a name.
pub const LEAST_PROBABLE: f64 = 0.001;
/// What is less probable than this needs a gain that is surely large.
const DOUBTFUL: f64 = 0.01;
/// What is at least as probable is more so than not.
pub const EVEN: f64 = 0.5;
/// What as many others explain as well says little of what is wrong: where a name must be more
/// probable than not, that must be so probable.
const MANY: usize = 2;
/// See [`MANY`]. Of three such names in 250 looked-at recordings of a loop two were false, of 0.54
/// and 0.55; the right one has 0.9.
const PROBABLE: f64 = 0.8;

/// Under what circumstances names are earned.
#[derive(Debug, Clone, Copy, Default)]
pub struct Circumstances {
    /// Asked what has changed since a calibration.
    pub change: bool,
    /// Of a board's loop whose drive is not recorded.
    pub looped: bool,
    /// The base model leaves no more than noise and a usual wander do.
    pub adequate: bool,
}

/// What has no name because something that need not be missing does as well.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unearned<'a> {
    /// Where smooth functions do.
    pub imitated: &'a [&'a str],
    /// Where an effect no larger than in sound rigs does.
    pub as_usual: &'a [&'a str],
}

/// Parts what was found into causes and what is modelled without a name. A name has a `probability`
/// that is worth a line. What has no size that is determined must be more probable than not. Where
/// the base model is adequate, all must be: nothing need be missing. Of a board's loop whose drive
/// is not recorded the error hardly tells what is wrong: there, too, all must be, but what makes it
/// hunt, in step with which no rollout does, and what is sure by itself. What ties with several
/// others must be more than that.
#[must_use]
pub fn part(
    found: Vec<Cause>,
    Unearned { imitated, as_usual }: Unearned<'_>,
    Circumstances { change, looped, adequate }: Circumstances,
    probability: impl Fn(&Cause) -> f64,
) -> (Vec<Cause>, Vec<Imperfection>) {
    let (mut causes, mut imperfections) = (Vec::new(), Vec::new());
    for cause in found {
        let among = |ids: &[&str], why| ids.contains(&cause.effect.as_str()).then_some(why);
        let alike = || among(as_usual, Unnamed::Usual).or_else(|| among(imitated, Unnamed::Imitated));
        let told_otherwise = change || looped && hunts(&cause) || is_sure_by_itself(&cause, looped);
        let must_be_even = (looped || adequate || is_undetermined(&cause)) && !told_otherwise;
        let large = cause.gain.weighted_ci95[0] >= SETTINGS.sure_gain;
        let least = match (must_be_even, large) {
            (true, _) if cause.equivalent.len() >= MANY => PROBABLE,
            (true, _) => EVEN,
            (false, true) => LEAST_PROBABLE,
            (false, false) => DOUBTFUL,
        };
        let improbable = || (probability(&cause) < least).then_some(Unnamed::Improbable);
        match why_not(&cause, change, looped).or_else(alike).or_else(improbable) {
            None => causes.push(cause),
            Some(why) => imperfections.push(Imperfection { why, cause }),
        }
    }
    (causes, imperfections)
}

/// What is missing for a name. Since a calibration nothing may have moved: there, no size is usual.
fn why_not(cause: &Cause, change: bool, looped: bool) -> Option<Unnamed> {
    if !change && is_usual(cause, looped) {
        return Some(Unnamed::Usual);
    }
    let [plain, weighted] =
        [cause.gain.ci95[0], cause.gain.weighted_ci95[0]].map(|low| low > SETTINGS.practical);
    // Of a loop that hunts the likelihood tells, and rollouts' errors hardly anything. Where they
    // are surely larger the likelihood must be sure, too.
    let hunting = looped && hunts(cause);
    if hunting && cause.gain.ci95[1] < 0.0 && cause.gain.weighted_ci95[0] < SETTINGS.sure_gain {
        return Some(Unnamed::Gainless);
    }
    let told_otherwise = change || hunting;
    let gains = if looped && !told_otherwise && may_be_usual(cause) {
        weighted
    } else {
        plain
            || weighted
            || (told_otherwise || !may_be_nothing(cause)) && cause.gain.reduction > SETTINGS.practical
    };
    (!gains).then_some(Unnamed::Gainless)
}

/// May, by its intervals, every size that tells how large it is be one that sound rigs have? A size
/// that is not determined may.
fn may_be_usual(cause: &Cause) -> bool {
    index_of(&cause.effect).is_some_and(|k| {
        telling(CATALOGUE[k]).next().is_some() && !stands_out(CATALOGUE[k], &cause.parameters, true)
    })
}

/// Is the size with its whole interval beyond what sound rigs have, and the gain on the test blocks
/// sure?
pub(super) fn is_sure_by_itself(cause: &Cause, looped: bool) -> bool {
    let size = |k: usize| stands_out(CATALOGUE[k], &cause.parameters, looped);
    index_of(&cause.effect).is_some_and(size) && cause.gain.weighted_ci95[0] >= SETTINGS.sure_gain
}

pub(super) fn hunts(cause: &Cause) -> bool {
    index_of(&cause.effect).is_some_and(|k| CATALOGUE[k].makes_limit_cycles())
}

/// Is none of the sizes that tell how large it is determined?
pub(super) fn is_undetermined(cause: &Cause) -> bool {
    of_all_sizes(cause, |_, ci95| ci95.is_none())
}

/// May, by its intervals, every size that tells how large it is be none? A size that is not
/// determined may.
pub(super) fn may_be_nothing(cause: &Cause) -> bool {
    of_all_sizes(cause, |parameter, ci95| {
        ci95.is_none_or(|[low, high]| (low..=high).contains(&parameter.null))
    })
}

/// Is this so of the intervals of all sizes that tell how large a cause is, and is there one?
fn of_all_sizes(cause: &Cause, is_so: impl Fn(&EffectParameter, Option<[f64; 2]>) -> bool) -> bool {
    index_of(&cause.effect).is_some_and(|k| {
        let mut telling = telling(CATALOGUE[k]).peekable();
        let ci95 = |p: &EffectParameter| cause.parameters.get(p.name).and_then(|size| size.ci95);
        telling.peek().is_some() && telling.all(|p| is_so(p, ci95(p)))
    })
}

/// A threshold with which a loop hunts may be anything between two steps of the drive, none
/// included, although the likelihood is sure that there is one.
fn is_usual(cause: &Cause, looped: bool) -> bool {
    let sure = cause.gain.weighted_ci95[0] >= SETTINGS.sure_gain;
    index_of(&cause.effect).map(|k| CATALOGUE[k]).is_some_and(|info| {
        let hunts_by_threshold = info.is_thresholded() && info.makes_limit_cycles();
        are_usual(info, &cause.parameters, looped, looped && !(hunts_by_threshold && sure))
    })
}

/// Are the sizes of an effect such as sound rigs have? Where no interval says how large it is, they
/// are not.
#[must_use]
pub fn usual(info: &EffectInfo, sizes: &Sizes, looped: bool) -> bool {
    are_usual(info, sizes, looped, looped)
}

/// The same; `doubt_tells`: a size that may be none is usual, however large.
fn are_usual(info: &EffectInfo, sizes: &Sizes, looped: bool, doubt_tells: bool) -> bool {
    let is_usual = |p: &EffectParameter| {
        let Some(size) = sizes.get(p.name) else { return false };
        let Some([low, high]) = size.ci95 else { return false };
        let doubtful = (low..=high).contains(&p.null);
        let usual_sizes = if doubtful { SETTINGS.usual_doubtful } else { 1.0 };
        doubtful && doubt_tells || p.distance(size.value) <= p.unsuspicious(looped) * usual_sizes
    };
    let mut telling = telling(info).peekable();
    telling.peek().is_some() && telling.all(is_usual)
}

/// Is one of them, with its whole interval, beyond that?
#[must_use]
pub fn stands_out(info: &EffectInfo, sizes: &Sizes, looped: bool) -> bool {
    let beyond = |p: &EffectParameter, [low, high]: [f64; 2]| {
        let nearest = f64::min(p.distance(low), p.distance(high));
        !(low..=high).contains(&p.null) && nearest > p.unsuspicious(looped)
    };
    telling(info).any(|p| sizes.get(p.name).and_then(|size| size.ci95).is_some_and(|range| beyond(p, range)))
}

/// An effect's parameters by name.
type Sizes = BTreeMap<String, Estimate>;

fn telling(info: &EffectInfo) -> impl Iterator<Item = &'static EffectParameter> {
    info.parameters.iter().filter(|p| p.usual.is_finite())
}

#[cfg(test)]
mod tests;
