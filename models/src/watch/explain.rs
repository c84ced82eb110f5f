//! From an alarm to what may explain it: every effect on the channel, those of the whole rig on all
//! channels, something else.

use super::channel::Channel;
use super::direction::Direction;
use super::event::{Change, Explanation, Where};
use super::glr::Alarm;
use super::naming::{Evidence, Fitted, common};
use crate::effects::Reach;
use crate::order::descending;

/// Explanations less probable are left out.
const LEAST: f64 = 0.01;
/// Standard errors of a 95 % interval.
const NORMAL95: f64 = 1.96;

/// What explains an alarm on channel `seen`.
pub fn explain(channels: &[Channel], seen: usize, alarm: &Alarm, t_s: f64) -> Change {
    let since_s = alarm.since_s;
    let evidence: Vec<Option<Evidence>> = channels.iter().map(|channel| channel.evidence(since_s)).collect();
    let own = &channels[seen];
    let mut found = Vec::new();
    if let Some(here) = &evidence[seen] {
        for (k, direction) in own.bank.directions.iter().enumerate() {
            let fitted = match direction.info().reach {
                Reach::Channel => here.of(k),
                Reach::Rig => on_rig(channels, &evidence, direction),
            };
            if direction.is_beyond(fitted.size, here.usual(k)) {
                continue;
            }
            let place = match direction.info().reach {
                Reach::Channel => Where::Channel(own.id),
                Reach::Rig => Where::Rig,
            };
            found.push((fitted.odds(), explanation(direction, place, &fitted)));
        }
        found.push((here.something_else(), unknown(own)));
    } else {
        found.push((0.0, unknown(own)));
    }
    let most = found.iter().map(|(odds, _)| *odds).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = found.iter().map(|(odds, _)| (odds - most).exp()).sum();
    let mut explanations: Vec<Explanation> = found
        .into_iter()
        .map(|(odds, e)| Explanation { probability: (odds - most).exp() / total, ..e })
        .filter(|e| e.probability >= LEAST)
        .collect();
    descending(&mut explanations, |item| item.probability);
    let Alarm { statistic, since_ci95_s, .. } = *alarm;
    Change { t_s, channel: own.id, since_s, since_ci95_s, statistic, explanations }
}

/// An effect with one size on all channels that were watched.
fn on_rig(channels: &[Channel], evidence: &[Option<Evidence>], direction: &Direction) -> Fitted {
    let of = |(channel, evidence): (&Channel, &Option<Evidence>)| {
        let place = channel.bank.directions.iter().position(|d| d.effect == direction.effect)?;
        Some(evidence.as_ref()?.of(place))
    };
    let fitted: Vec<Fitted> = channels.iter().zip(evidence).filter_map(of).collect();
    common(&fitted)
}

fn explanation(direction: &Direction, place: Where, fitted: &Fitted) -> Explanation {
    let info = direction.info();
    let parameter = &info.parameters[0];
    let ends = [-NORMAL95, NORMAL95].map(|n| direction.size(fitted.size + n * fitted.standard_error));
    Explanation {
        effect: info.id,
        place,
        probability: 0.0,
        parameter: Some(parameter.name),
        value: Some(direction.size(fitted.size)),
        ci95: Some([ends[0].min(ends[1]), ends[0].max(ends[1])]),
        unit: Some(parameter.unit),
    }
}

fn unknown(channel: &Channel) -> Explanation {
    Explanation {
        effect: "something_else",
        place: Where::Channel(channel.id),
        probability: 0.0,
        parameter: None,
        value: None,
        ci95: None,
        unit: None,
    }
}
