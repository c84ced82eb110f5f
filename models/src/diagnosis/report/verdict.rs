//! The verdict in words, each with its numbers.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::json::{Cause, Report, Verdict, Withheld};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::{CATALOGUE, index_of};

/// Title of an effect.
#[must_use]
pub fn title(id: &str) -> &str {
    index_of(id).map_or(id, |k| CATALOGUE[k].title)
}

impl Verdict {
    /// Of whether anything has a name, and whether what is left counts.
    #[must_use]
    pub fn new(named: bool, rest: bool) -> Self {
        match (named, rest) {
            (false, false) => Self::Adequate,
            (false, true) => Self::Unexplained,
            (true, false) => Self::Explained,
            (true, true) => Self::PartlyExplained,
        }
    }
}

/// Is a cause more than probable?
#[must_use]
pub fn is_sure(cause: &Cause) -> bool {
    let likely = cause.probability.is_none_or(|p| p >= SETTINGS.sure_probability);
    likely && cause.gain.ci95[0] >= SETTINGS.sure_gain && cause.p_value <= SETTINGS.sure_p
}

/// A cause, how sure it is, and what it cannot be told from.
#[must_use]
pub fn name(cause: &Cause) -> String {
    let mut text = format!("\"{}\"", title(&cause.effect));
    if cause.equivalent.is_empty() {
        if !is_sure(cause) {
            text = format!("probably {text}");
        }
    } else {
        let rivals: Vec<String> = cause.equivalent.iter().map(|id| format!("\"{}\"", title(id))).collect();
        text = format!("either {text} or {} (this recording cannot tell them apart)", rivals.join(" or "));
    }
    text
}

/// Why a name was not given.
#[must_use]
pub fn withheld(Withheld { effect, foil }: &Withheld) -> String {
    let apart = index_of(foil).map_or("", |k| CATALOGUE[k].separated_by);
    format!(
        "\"{}\" would explain it, but \"{}\", which is not in the catalogue, explains it as well, so neither is named. What tells them apart: {apart}.",
        title(effect),
        title(foil)
    )
}

/// A remark on models whose supply is not what the rig file states.
#[must_use]
pub fn other_supply(channels: &[ChannelData], models: &[Extended]) -> Option<String> {
    let shares = channels.iter().zip(models).flat_map(|(data, model)| {
        let stated = |e: &&usize| CATALOGUE[**e].needs_stated_supply();
        let range = model.effects.iter().find(stated).and_then(|&e| model.range(&data.plant, e));
        range.map(|range| model.values[range.start])
    });
    let shares: Vec<f64> = shares.collect();
    let percent = 100.0 * shares.iter().sum::<f64>() / shares.len() as f64;
    let direction = if percent < 0.0 { "less" } else { "more" };
    (!shares.is_empty()).then(|| {
        format!(
            "The extended model takes the supply's absolute pressure for {:.1} % {direction} than the rig file states: beside what is named, the supply is another, or something does much the same. A recorded supply pressure would tell.",
            percent.abs()
        )
    })
}

/// By how much the error falls with some causes, from errors before and after and the noise, kPa.
fn fallen(causes: &[Cause], [before, after, noise]: [f64; 3]) -> String {
    let percent = |share: f64| (100.0 * share).round();
    let reduction = percent(1.0 - after / before);
    let data = "on data that was not used for fitting";
    let weighed: Vec<String> = causes
        .iter()
        .map(|cause| cause.gain.weighted_ci95.map(percent))
        .map(|[low, high]| format!("{low:.0} to {high:.0} %"))
        .collect();
    if reduction >= 1.0 || weighed.is_empty() {
        return format!(
            "With it the simulation error {data} falls from {before:.2} to {after:.2} kPa ({reduction:.0} % less; sensor noise is {noise:.2} kPa)."
        );
    }
    format!(
        "With it the simulation error {data} does not fall in plain kilopascals ({before:.2} to {after:.2}; sensor noise is {noise:.2} kPa), but does by {} where it is weighed by what noise, the supply's wander and a loop's hunting explain.",
        weighed.join(" and ")
    )
}

/// That not the whole catalogue was in question, where that is so.
#[must_use]
pub fn asked_about(asked: &[String]) -> String {
    let titles: Vec<String> = asked.iter().map(|id| format!("\"{}\"", title(id))).collect();
    if titles.is_empty() {
        String::new()
    } else {
        format!(" Nothing but {} was asked about.", titles.join(" or "))
    }
}

/// The verdict in a sentence or two.
#[must_use]
pub fn sentence(report: &Report, change: bool) -> String {
    let before = report.baseline.test_rmse_kpa;
    let after = report.unexplained.test_rmse_kpa;
    let noise = report.baseline.noise_floor_kpa;
    let allowed = report.checks.allowed_rmse_kpa;
    let names: Vec<String> = report.causes.iter().map(name).collect();
    let names = names.join(" and ");
    let found = if change { "Changed since the calibration" } else { "Missing from the model" };
    let gain = fallen(&report.causes, [before, after, noise]);
    let left: Vec<String> = report
        .unexplained
        .depends_on
        .iter()
        .map(|s| s.what.replace("the residual depends on ", ""))
        .collect();
    let small: Vec<&str> = report.imperfections.iter().map(|i| title(&i.cause.effect)).collect();
    let small = if small.is_empty() {
        String::new()
    } else {
        format!(
            " The extended model also has {}, no larger than sound rigs do, in a size that may be nothing or is not told, without a gain that is sure and worth a name, or improbable.",
            small.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" and ")
        )
    };
    let unnamed = if small.is_empty() { before } else { after };
    let (among, not, cause) = if report.asked.is_empty() {
        ("in the catalogue", "not in the catalogue", "no known cause")
    } else {
        ("of what was asked about", "none of what was asked about", "nothing of that")
    };
    let verdict = match report.verdict {
        Verdict::Adequate if change => format!(
            "Nothing has moved that this recording could show: the calibrated model simulates it with an error of {before:.2} kPa (sensor noise {noise:.2} kPa)."
        ),
        Verdict::Adequate if !small.is_empty() && after < before => format!(
            "The model is adequate for this recording once it has effects that have not earned a name: it then simulates the test blocks with an error of {after:.2} kPa instead of {before:.2} kPa (sensor noise {noise:.2} kPa)."
        ),
        Verdict::Adequate => format!(
            "The model is adequate for this recording: it simulates the test blocks with an error of {before:.2} kPa (sensor noise {noise:.2} kPa), and nothing {among} would make that better by more than chance."
        ),
        Verdict::Explained => format!("{found}: {names}. {gain} What remains shows no pattern."),
        Verdict::PartlyExplained if left.is_empty() => format!(
            "{found}: {names}. {gain} That is not all: what remains is more than the {allowed:.2} kPa that noise and a usual wander of the supply leave, but depends on nothing that was measured."
        ),
        Verdict::PartlyExplained => format!(
            "{found}: {names}. {gain} That is not all: what remains still depends on {}.",
            left.join(", ")
        ),
        Verdict::Unexplained if let Some(name) = &report.unexplained.withheld => format!(
            "The model misses something: its error on the test blocks is {unnamed:.2} kPa where noise and a usual wander of the supply leave {allowed:.2} kPa. {}",
            withheld(name)
        ),
        Verdict::Unexplained if left.is_empty() => format!(
            "The model misses something that is {not}: its error on the test blocks is {unnamed:.2} kPa where noise and a usual wander of the supply leave {allowed:.2} kPa, but it depends on nothing that was measured, and {cause} explains it. Something may come and go by itself: look at the residual over time. If it is large everywhere, check the rig file, the units and the columns."
        ),
        Verdict::Unexplained => format!(
            "The model misses something that is {not}: its error ({unnamed:.2} kPa on the test blocks, sensor noise {noise:.2} kPa) depends on {}, and {cause} explains it.",
            left.join(", ")
        ),
    };
    verdict + &small + &asked_about(&report.asked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::json::{Imperfection, Unnamed};
    use crate::diagnosis::testing::{cause, channel, report, with};

    #[test]
    fn a_verdict_about_some_effects_speaks_of_no_catalogue() {
        let asked = || vec!["valve_lag".to_owned(), "supply_sag".to_owned()];
        for verdict in [Verdict::Adequate, Verdict::Unexplained] {
            let whole = report(verdict, [0.9, 0.9]);
            assert!(sentence(&whole, false).contains("in the catalogue"));
            let some = sentence(&Report { asked: asked(), ..whole }, false);
            assert!(!some.contains("catalogue") && !some.contains("known cause"), "{some}");
            assert!(some.ends_with(" was asked about.") && some.contains(title("supply_sag")), "{some}");
        }
    }

    #[test]
    fn a_name_that_is_withheld_is_told_with_what_it_is_confused_with_and_what_would_tell_them_apart() {
        let of = |effect: &str, foil: &str| Withheld { effect: effect.to_owned(), foil: foil.to_owned() };
        let text = withheld(&of("sensor_crosstalk", "drive_crosstalk"));
        for part in
            ["Reading contains", "Drive contains", "neither is named", "the one before it is driven hard"]
        {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn what_falls_only_where_errors_are_weighed_is_told_so() {
        let mut hunting = cause("valve_stiction", 0.0);
        hunting.gain.weighted_ci95 = [0.302, 0.642];
        let plain = fallen(std::slice::from_ref(&hunting), [1.2, 0.6, 0.3]);
        assert!(plain.contains("from 1.20 to 0.60 kPa (50 % less"), "{plain}");
        for after in [1.199, 1.3] {
            let weighed = fallen(std::slice::from_ref(&hunting), [1.2, after, 0.3]);
            assert!(weighed.contains("does not fall") && weighed.contains("by 30 to 64 %"), "{weighed}");
        }
    }

    #[test]
    fn a_supply_that_is_not_as_stated_is_told_with_its_direction_and_size() {
        let (data, base) = channel(false);
        let of = |shares: &[f64]| {
            let models = shares.iter().map(|&share| with(&data, &base, "supply_misstated", &[share]));
            other_supply(&vec![data.clone(); shares.len()], &models.collect::<Vec<_>>())
        };
        let text = of(&[-0.04, -0.06]).expect("both have it");
        assert!(text.contains("5.0 % less than the rig file states"), "{text}");
        assert!(of(&[0.02]).expect("it has it").contains("2.0 % more"), "{text}");
        assert_eq!(other_supply(&[data], &[base]), None);
    }

    /// The sentence of an adequate model with effects that have no name, and the errors with it.
    fn adequate(effects: &[&str], errors_kpa: [f64; 2]) -> String {
        let mut report = report(Verdict::Adequate, errors_kpa);
        let unnamed = |id: &&str| Imperfection { why: Unnamed::Usual, cause: cause(id, 0.0) };
        report.imperfections = effects.iter().map(unnamed).collect();
        sentence(&report, false)
    }

    #[test]
    fn an_adequate_model_owes_its_error_to_unnamed_effects_only_where_they_make_it_smaller() {
        let with_lag = "The extended model also has \"Spool follows with a lag\"";
        let alone = adequate(&[], [0.6, 0.6]);
        assert!(alone.contains("an error of 0.60 kPa") && !alone.contains("The extended model"), "{alone}");
        let closer = adequate(&["valve_lag"], [0.6, 0.4]);
        assert!(closer.contains("0.40 kPa instead of 0.60 kPa") && closer.contains(with_lag), "{closer}");
        for after in [0.6, 0.7] {
            let no_closer = adequate(&["valve_lag"], [0.6, after]);
            assert!(no_closer.contains("with an error of 0.60 kPa"), "{no_closer}");
            assert!(no_closer.contains(with_lag) && !no_closer.contains("instead"), "{no_closer}");
        }
    }

    #[test]
    fn what_stays_unexplained_is_told_with_the_error_of_the_model_that_is_written() {
        let mut report = report(Verdict::Unexplained, [0.9, 0.8]);
        assert!(sentence(&report, false).contains("is 0.90 kPa"), "{}", sentence(&report, false));
        report.imperfections = vec![Imperfection { why: Unnamed::Usual, cause: cause("valve_lag", 0.0) }];
        assert!(sentence(&report, false).contains("is 0.80 kPa"), "{}", sentence(&report, false));
        report.unexplained.withheld =
            Some(Withheld { effect: "sensor_crosstalk".into(), foil: "drive_crosstalk".into() });
        let text = sentence(&report, false);
        assert!(text.contains("is 0.80 kPa") && text.contains("neither is named"), "{text}");
    }
}
