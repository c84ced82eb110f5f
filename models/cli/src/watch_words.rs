//! What a watcher says, in sentences.

use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::report::{behind, significant};
use pneudrive_model::watch::{Change, Explanation, Learnt};

/// A channel is watched from now on.
pub fn learnt(about: &Learnt) -> String {
    format!(
        "t = {:.1} s: {} is watched from now on; what is usual was learnt from {:.0} s (innovations {} kPa RMS)",
        about.t_s,
        about.channel,
        about.seconds,
        significant(about.innovation_kpa, 2)
    )
}

/// Something has changed.
pub fn changed(about: &Change) -> String {
    let [early, late] = about.since_ci95_s;
    let mut text = format!(
        "t = {:.1} s: {} has changed since t = {:.0} s ({early:.0} to {late:.0} s): ",
        about.t_s, about.channel, about.since_s
    );
    match about.explanations.split_first() {
        None => text.push_str("nothing explains it"),
        Some((best, rest)) => {
            text.push_str(&one(best));
            if !rest.is_empty() {
                let rest: Vec<String> = rest.iter().take(4).map(short).collect();
                text.push_str(&format!("; or {}", rest.join(", ")));
            }
        }
    }
    text
}

fn one(explanation: &Explanation) -> String {
    let Explanation { effect, place, .. } = explanation;
    let percent = percent(explanation.probability);
    let info = CATALOGUE.iter().find(|info| info.id == *effect);
    match (info, explanation.parameter, explanation.value, explanation.ci95) {
        (Some(info), Some(parameter), Some(value), Some([low, high])) => {
            let unit = explanation.unit.map_or_else(String::new, behind);
            format!(
                "{} ({effect}, {place}), {percent}, {parameter} now {}{unit} ({} to {}); at the rig: {}",
                info.title,
                significant(value, 3),
                significant(low, 3),
                significant(high, 3),
                info.check
            )
        }
        _ => format!("something that is not in the catalogue, {percent}"),
    }
}

fn short(explanation: &Explanation) -> String {
    format!("{} ({})", explanation.effect, percent(explanation.probability))
}

/// Nothing is certain.
fn percent(probability: f64) -> String {
    if probability > 0.99 { "over 99 %".to_owned() } else { format!("{:.0} %", 100.0 * probability) }
}
