//! What the diagnosis says of fixed recordings, as a file: what a change of the code is compared
//! with.
//!
//! The table does not say what is right, only what was said: a rewrite that keeps the behaviour
//! keeps the table.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::plan::Case;

/// Significant digits that are kept: more than any interval is worth, fewer than rounding disturbs.
const DIGITS: i32 = 6;
/// Part of an error in kilopascals by which it may move: errors have no interval.
const ERROR_SHARE: f64 = 0.01;

/// The whole file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// The recordings, in the order in which they are made.
    pub recordings: Vec<Entry>,
}

/// One recording and what was said of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Name, unique in the table: round and number of the case.
    pub name: String,
    /// Seed of the recording.
    pub seed: u64,
    /// Is the drive recorded?
    pub drive: bool,
    /// What is hidden, as the truth plant reads it.
    pub hidden: Vec<String>,
    /// The verdict.
    pub verdict: String,
    /// RMS error of the base model on the test blocks, kPa.
    pub base_rmse_kpa: f64,
    /// RMS error of the extended model on the test blocks, kPa.
    pub rest_rmse_kpa: f64,
    /// By channel, what the unnamed correction depends on.
    pub correction: BTreeMap<String, String>,
    /// What was named, in the order of the report.
    pub causes: Vec<Named>,
}

/// A named cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its id.
    pub effect: String,
    /// Where it acts.
    pub channels: Vec<String>,
    /// Effects that explain the recording as well.
    pub equivalent: Vec<String>,
    /// Part by which it lowers the RMS error on the test blocks.
    pub gain: Number,
    /// Its parameters, over the channels where it acts.
    pub sizes: BTreeMap<String, Number>,
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Best value.
    pub value: f64,
    /// Interval; none where the recording does not determine the number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ci95: Option<[f64; 2]>,
}

impl Entry {
    /// What `report` (the content of `report.json`) says of `case`; `None` when it lacks something.
    #[must_use]
    pub fn new(name: &str, case: &Case, report: &Value) -> Option<Self> {
        let correction = match &report["unexplained"]["correction"] {
            Value::Null => BTreeMap::new(),
            found => serde_json::from_value(found["along"].clone()).ok()?,
        };
        Some(Self {
            name: name.to_owned(),
            seed: case.seed,
            drive: case.drive,
            hidden: case.arguments.clone(),
            verdict: report["verdict"].as_str()?.to_owned(),
            base_rmse_kpa: rounded(report["baseline"]["test_rmse_kpa"].as_f64()?),
            rest_rmse_kpa: rounded(report["unexplained"]["test_rmse_kpa"].as_f64()?),
            correction,
            causes: report["causes"].as_array()?.iter().map(Named::new).collect::<Option<_>>()?,
        })
    }
}

impl Named {
    fn new(cause: &Value) -> Option<Self> {
        let strings = |key: &str| serde_json::from_value(cause[key].clone()).ok();
        let parameters = cause["parameters"].as_object()?;
        Some(Self {
            effect: cause["effect"].as_str()?.to_owned(),
            channels: strings("channels")?,
            equivalent: strings("equivalent")?,
            gain: Number::new(&cause["gain"], "reduction")?,
            sizes: parameters
                .iter()
                .map(|(name, estimate)| Some((name.clone(), Number::new(estimate, "value")?)))
                .collect::<Option<_>>()?,
        })
    }
}

impl Number {
    fn new(estimate: &Value, key: &str) -> Option<Self> {
        let ci95: Option<[f64; 2]> = serde_json::from_value(estimate["ci95"].clone()).ok()?;
        Some(Self { value: rounded(estimate[key].as_f64()?), ci95: ci95.map(|ends| ends.map(rounded)) })
    }

    /// The largest move of the value or an end of the interval, as a part of the interval's width,
    /// or of the value where there is no interval; infinite when only one of the two has an
    /// interval.
    fn moved(&self, now: &Self) -> f64 {
        let (moves, width) = match (self.ci95, now.ci95) {
            (Some(then), Some(ends)) => {
                (vec![now.value - self.value, ends[0] - then[0], ends[1] - then[1]], then[1] - then[0])
            }
            (None, None) => (vec![now.value - self.value], self.value.abs()),
            _ => return f64::INFINITY,
        };
        let largest = moves.iter().map(|m| m.abs()).fold(0.0, f64::max);
        if largest > 0.0 { largest / width } else { 0.0 }
    }
}

impl Table {
    /// What differs in `now`, in sentences: names always, numbers where they have moved by more
    /// than `share` of their interval. Recordings of this table that `now` lacks are differences
    /// too.
    #[must_use]
    pub fn differences(&self, now: &Self, share: f64) -> Vec<String> {
        let mut found = Vec::new();
        for then in &self.recordings {
            match now.recordings.iter().find(|entry| entry.name == then.name) {
                Some(entry) => {
                    compare(then, entry, share, &mut |text| found.push(format!("{}: {text}", then.name)))
                }
                None => found.push(format!("{}: is missing", then.name)),
            }
        }
        let known = |entry: &&Entry| !self.recordings.iter().any(|then| then.name == entry.name);
        found.extend(now.recordings.iter().filter(known).map(|entry| format!("{}: is new", entry.name)));
        found
    }
}

fn compare(then: &Entry, now: &Entry, share: f64, tell: &mut dyn FnMut(String)) {
    let made = |e: &Entry| format!("seed {}, drive {}, hidden {:?}", e.seed, e.drive, e.hidden);
    words("the recording is another", &made(then), &made(now), tell);
    words("verdict", &then.verdict, &now.verdict, tell);
    words("correction", &format!("{:?}", then.correction), &format!("{:?}", now.correction), tell);
    let errors =
        [("base", then.base_rmse_kpa, now.base_rmse_kpa), ("rest", then.rest_rmse_kpa, now.rest_rmse_kpa)];
    for (what, before, after) in errors {
        if !((after - before).abs() <= ERROR_SHARE * before) {
            tell(format!("error of the {what} was {before} kPa, is {after}"));
        }
    }
    let names = |e: &Entry| {
        let one = |c: &Named| format!("{} on {:?} or {:?}", c.effect, c.channels, c.equivalent);
        e.causes.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    words("named", &names(then), &names(now), tell);
    for (a, b) in then.causes.iter().zip(&now.causes).filter(|(a, b)| a.effect == b.effect) {
        number(&format!("gain of {}", a.effect), &a.gain, &b.gain, share, tell);
        for (name, size) in &a.sizes {
            let what = format!("{}.{name}", a.effect);
            match b.sizes.get(name) {
                Some(after) => number(&what, size, after, share, tell),
                None => tell(format!("{what} is missing")),
            }
        }
    }
}

fn words(what: &str, then: &str, now: &str, tell: &mut dyn FnMut(String)) {
    if then != now {
        tell(format!("{what}: was {then}, is {now}"));
    }
}

fn number(what: &str, then: &Number, now: &Number, share: f64, tell: &mut dyn FnMut(String)) {
    let moved = then.moved(now);
    if !(moved <= share) {
        tell(format!(
            "{what} was {} {:?}, is {} {:?}: {moved:.3} of its interval",
            then.value, then.ci95, now.value, now.ci95
        ));
    }
}

/// To [`DIGITS`] significant digits.
fn rounded(value: f64) -> f64 {
    let digits = usize::try_from(DIGITS - 1).unwrap_or(0);
    format!("{value:.digits$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::super::plan::Kind;
    use super::*;
    use serde_json::json;

    fn report() -> Value {
        json!({
            "verdict": "explained",
            "baseline": {"test_rmse_kpa": 2.000_000_4},
            "unexplained": {"test_rmse_kpa": 0.7, "correction": {"along": {"b0c1": "the drive"}, "reduction": 0.1}},
            "causes": [{
                "effect": "valve_lag", "channels": ["b0c0", "b0c1"], "equivalent": ["sensor_lag"],
                "gain": {"reduction": 0.5, "ci95": [0.4, 0.6]},
                "parameters": {"time_constant": {"value": 0.02, "ci95": [0.019, 0.021]}, "free": {"value": 3.0, "ci95": null}},
            }],
        })
    }

    fn table(report: &Value) -> Table {
        let arguments = vec!["valve_lag=0.02".to_owned()];
        let case = Case { number: 3, arguments, seed: 7, ..Case::moderate(Kind::Single, &["valve_lag"]) };
        Table { recordings: vec![Entry::new("r0c003", &case, report).unwrap()] }
    }

    /// The differences that follow from one change of the report.
    fn after(change: impl Fn(&mut Value)) -> Vec<String> {
        let mut changed = report();
        change(&mut changed);
        table(&report()).differences(&table(&changed), 0.1)
    }

    #[test]
    fn a_report_is_kept_with_few_digits() {
        let kept = table(&report());
        assert_eq!(kept.recordings[0].base_rmse_kpa, 2.0);
        assert_eq!(kept.recordings[0].causes[0].sizes["free"], Number { value: 3.0, ci95: None });
        let text = toml::to_string_pretty(&kept).unwrap();
        assert_eq!(toml::from_str::<Table>(&text).unwrap(), kept);
    }

    #[test]
    fn what_has_not_changed_makes_no_difference() {
        assert_eq!(after(|_| {}), Vec::<String>::new());
        // A twentieth of the interval, half a percent of an error.
        assert_eq!(after(|r| r["causes"][0]["gain"]["reduction"] = json!(0.51)), Vec::<String>::new());
        assert_eq!(after(|r| r["unexplained"]["test_rmse_kpa"] = json!(0.7035)), Vec::<String>::new());
    }

    #[test]
    fn every_name_and_every_number_makes_a_difference() {
        let one = |change: &dyn Fn(&mut Value), part: &str| {
            let found = after(change);
            assert!(found.len() == 1 && found[0].contains(part), "{part}: {found:?}");
        };
        let cause =
            |key: &'static str, value: Value| move |r: &mut Value| r["causes"][0][key] = value.clone();
        let size = |key: &'static str, value: Value| {
            move |r: &mut Value| r["causes"][0]["parameters"]["time_constant"][key] = value.clone()
        };
        one(&|r| r["verdict"] = json!("adequate"), "verdict: was explained, is adequate");
        one(&|r| r["baseline"]["test_rmse_kpa"] = json!(2.03), "error of the base");
        one(&|r| r["unexplained"]["test_rmse_kpa"] = json!(0.69), "error of the rest");
        one(&|r| r["unexplained"]["correction"]["along"] = json!({}), "correction");
        one(&cause("effect", json!("sensor_lag")), "named");
        one(&cause("channels", json!(["b0c0"])), "named");
        one(&cause("equivalent", json!([])), "named");
        one(&cause("gain", json!({"reduction": 0.53, "ci95": [0.4, 0.6]})), "gain of valve_lag was 0.5");
        one(&size("value", json!(0.0203)), "valve_lag.time_constant was 0.02");
        one(&size("ci95", json!([0.019, 0.0213])), "0.150 of its interval");
        one(&size("ci95", Value::Null), "inf of its interval");
        one(&|r| r["causes"][0]["parameters"]["free"]["value"] = json!(2.0), "valve_lag.free");
        one(&|r| r["causes"] = json!([]), "named");
    }

    #[test]
    fn a_recording_that_is_missing_new_or_another_makes_a_difference() {
        let (known, none) = (table(&report()), Table { recordings: Vec::new() });
        assert_eq!(known.differences(&none, 0.1), ["r0c003: is missing"]);
        assert_eq!(none.differences(&known, 0.1), ["r0c003: is new"]);
        let mut other = known.clone();
        other.recordings[0].seed = 8;
        assert!(known.differences(&other, 0.1)[0].contains("the recording is another"));
    }
}
