//! Parameter files of several recordings as one series for each channel and parameter.

use crate::order::ascending;
use std::collections::BTreeMap;

use serde::Serialize;

use super::changes::{Levels, levels};
use super::point::Point;
use crate::data::ChannelId;
use crate::store::ParameterFile;

/// What was fitted to one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// When it was recorded, s since 1970.
    pub unix_s: f64,
    /// Its parameters.
    pub parameters: ParameterFile,
}

/// A parameter over time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trend {
    /// The channel.
    pub channel: ChannelId,
    /// The parameter's name in its model.
    pub parameter: String,
    /// Unit of its values, `1` for none.
    pub unit: String,
    /// Its values, the earliest first; recordings that do not determine it are left out.
    pub points: Vec<Point>,
    /// Its levels and where they change.
    #[serde(flatten)]
    pub levels: Levels,
}

/// The trends of every channel and parameter, in the order of their names. The order of the
/// calibrations does not matter.
///
/// A change is marked where so large a one would be seen anywhere in these series by chance in one
/// of twenty such pages.
#[must_use]
pub fn trends(calibrations: &[Calibration]) -> Vec<Trend> {
    let mut ordered: Vec<&Calibration> = calibrations.iter().collect();
    ascending(&mut ordered, |item| item.unix_s);
    let mut series: BTreeMap<(ChannelId, usize, &str), (&str, Vec<Point>)> = BTreeMap::new();
    for Calibration { unix_s, parameters } in ordered {
        for (channel, own) in &parameters.channels {
            for (place, one) in own.parameters.iter().enumerate().filter(|(_, one)| one.determined) {
                let key = (*channel, place, one.name.as_str());
                let (_, points) = series.entry(key).or_insert_with(|| (one.unit.as_str(), Vec::new()));
                points.push(Point { unix_s: *unix_s, value: one.value, ci95: one.ci95 });
            }
        }
    }
    let chances: usize = series.values().map(|(_, points)| points.len().saturating_sub(1)).sum();
    let trend =
        |((channel, _, name), (unit, points)): ((ChannelId, usize, &str), (&str, Vec<Point>))| Trend {
            channel,
            parameter: name.to_owned(),
            unit: unit.to_owned(),
            levels: levels(&points, chances),
            points,
        };
    series.into_iter().map(trend).collect()
}
