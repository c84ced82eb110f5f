//! What is hidden in which recording.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

/// Effects of the catalogue with their detection limit, moderate and gross size in the truth
/// plant's units.
pub const CATALOGUE: [(&str, [f64; 3]); 21] = [
    ("supply_sag", [10.0, 40.0, 120.0]),
    ("supply_ripple", [8.0, 20.0, 60.0]),
    ("transport_delay", [0.005, 0.012, 0.05]),
    ("valve_lag", [0.006, 0.02, 0.08]),
    ("valve_hysteresis", [0.01, 0.05, 0.15]),
    // Between the steps of a drive that moves by one count of the sensor, 0.025: at a step itself
    // rounding decides whether the spool tears off, and below the first it always does.
    ("valve_stiction", [0.03, 0.06, 0.14]),
    ("drive_saturation", [0.9, 0.7, 0.4]),
    ("valve_asymmetry", [0.92, 0.7, 0.4]),
    ("vent_restriction", [0.25, 0.8, 2.5]),
    ("flow_function", [0.06, 0.2, 0.35]),
    ("heat_exchange", [0.05, 0.5, 3.0]),
    ("wall_compliance", [0.15, 0.8, 3.0]),
    ("wall_creep", [0.2, 0.8, 3.0]),
    ("line_restriction", [0.15, 0.8, 2.5]),
    ("chamber_coupling", [0.3, 1.5, 3.0]),
    ("sensor_lag", [0.006, 0.02, 0.08]),
    ("sensor_nonlinearity", [5.0, 25.0, 60.0]),
    ("sensor_drift", [2.0, 8.0, 30.0]),
    ("sensor_crosstalk", [0.008, 0.04, 0.15]),
    ("valve_wear", [-0.04, -0.15, -0.4]),
    ("stale_samples", [0.05, 0.2, 0.5]),
];

/// Effects that are not in the diagnosis' catalogue, at the plant's moderate size.
pub const OFF_CATALOGUE: [&str; 9] = [
    "line_water",
    "chamber_burst",
    "supply_temperature",
    "spool_stick",
    "drive_crosstalk",
    "coil_heating",
    "regulator_backlash",
    "sensor_hysteresis",
    "driver_resolution",
];

/// What kind of case it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing is hidden.
    Null,
    /// One effect on all channels.
    Single,
    /// One effect on one channel.
    OneChannel,
    /// Two effects.
    Pair,
    /// One effect that is not in the catalogue.
    OffCatalogue,
}

/// One case: the truth, and how its recording is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Number, and name of its folder.
    pub number: usize,
    /// Kind.
    pub kind: Kind,
    /// What is hidden: ids.
    pub effects: Vec<String>,
    /// The same as the truth plant reads it, with sizes and scope.
    pub arguments: Vec<String>,
    /// Size class: `limit`, `moderate` or `gross`.
    pub size: String,
    /// Seed of excitation, noise, spread and wander.
    pub seed: u64,
    /// Is the drive recorded (and the loop closed once a row)?
    pub drive: bool,
    /// What is not as the textbook and the rig file say, in a hard round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hard: Option<Hard>,
}

#[cfg(test)]
impl Case {
    /// A case of a moderate size with recorded drives, for tests of what is made of it.
    pub fn moderate(kind: Kind, effects: &[&str]) -> Self {
        Self {
            number: 0,
            kind,
            effects: effects.iter().map(|&effect| effect.to_owned()).collect(),
            arguments: Vec::new(),
            size: "moderate".to_owned(),
            seed: 1,
            drive: true,
            hard: None,
        }
    }
}

/// How a hard round's recording is made: by a rig with a background of imperfections, which its
/// file describes wrongly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hard {
    /// Rows a second.
    pub rate_hz: f64,
    /// Length, s.
    pub seconds: f64,
    /// Volume in the rig file over the true one.
    pub stated_volume: f64,
    /// Supply pressure in the rig file over the true one.
    pub stated_supply: f64,
    /// Largest error of a time stamp, part of a row's interval.
    pub jitter: f64,
}

/// Rates of hard rounds, Hz: recorded drives, and loops on the board.
const RATES_HZ: [f64; 4] = [50.0, 100.0, 200.0, 500.0];

/// The cases of a round, each with circumstances of its own, drawn beside it: the same seed hides
/// the same things.
#[must_use]
pub fn hard(seed: u64, cases: Vec<Case>) -> Vec<Case> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed ^ 0x6861_7264);
    let mut within = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let drawn = cases.into_iter().map(|case| {
        let rate = within(0.0, RATES_HZ.len() as f64) as usize;
        let hard = Hard {
            rate_hz: RATES_HZ[rate.min(RATES_HZ.len() - 1)],
            seconds: within(60.0, 300.0).round(),
            stated_volume: within(0.9, 1.1),
            stated_supply: within(0.95, 1.05),
            jitter: 0.05,
        };
        Case { hard: Some(hard), ..case }
    });
    drawn.collect()
}

/// The same cases in recordings of which a thousand can be diagnosed in an hour: on channels that
/// they have, of hard ones a minute with no more than 100 rows a second.
#[must_use]
pub fn short(mut cases: Vec<Case>) -> Vec<Case> {
    for case in &mut cases {
        for argument in &mut case.arguments {
            if let Some((effect, channel)) = argument.split_once("@b0c") {
                let channel: usize = channel.parse().unwrap_or(0);
                *argument = format!("{effect}@b0c{}", channel % SHORT_CHANNELS);
            }
        }
        if let Some(hard) = &mut case.hard {
            hard.seconds = SHORT_S;
            hard.rate_hz = hard.rate_hz.min(100.0);
        }
    }
    cases
}

/// Names of the size classes.
pub const SIZES: [&str; 3] = ["limit", "moderate", "gross"];

/// A round of cases: every effect of the catalogue at one size, as many nulls as a third of them,
/// one-channel cases, pairs and effects off the catalogue. The same seed gives the same cases.
#[must_use]
pub fn round(seed: u64, size: usize, drive: bool) -> Vec<Case> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut cases = Vec::new();
    let mut add = |kind: Kind, effects: Vec<String>, arguments: Vec<String>| {
        let number = cases.len();
        cases.push(Case {
            number,
            kind,
            effects,
            arguments,
            size: SIZES[size].to_owned(),
            seed: seed.wrapping_mul(1000).wrapping_add(number as u64),
            drive,
            hard: None,
        });
    };
    let argument = |(id, sizes): &(&str, [f64; 3]), scope: &str| format!("{id}={}{scope}", sizes[size]);
    for entry in &CATALOGUE {
        add(Kind::Single, vec![entry.0.to_owned()], vec![argument(entry, "")]);
    }
    for _ in 0..CATALOGUE.len() / 3 {
        add(Kind::Null, Vec::new(), Vec::new());
    }
    // What sits in one channel: not the supply, not the joint.
    let local: Vec<_> =
        CATALOGUE.iter().filter(|e| !e.0.starts_with("supply") && e.0 != "chamber_coupling").collect();
    for _ in 0..4 {
        let entry = local[rng.random_range(0..local.len())];
        let scope = format!("@b0c{}", rng.random_range(0..4));
        add(Kind::OneChannel, vec![entry.0.to_owned()], vec![argument(entry, &scope)]);
    }
    for _ in 0..5 {
        let first = rng.random_range(0..CATALOGUE.len());
        let second = (first + rng.random_range(1..CATALOGUE.len())) % CATALOGUE.len();
        let pair = [&CATALOGUE[first], &CATALOGUE[second]];
        add(
            Kind::Pair,
            pair.iter().map(|e| e.0.to_owned()).collect(),
            pair.iter().map(|e| argument(e, "")).collect(),
        );
    }
    for id in OFF_CATALOGUE {
        add(Kind::OffCatalogue, vec![id.to_owned()], vec![id.to_owned()]);
    }
    cases
}

/// Channels of short recordings: of those that are many, and of the table's.
pub const SHORT_CHANNELS: usize = 2;

/// Length of short recordings, s.
pub const SHORT_S: f64 = 60.0;

/// The rounds of the table of what the diagnosis says: seed, size and whether the drive is
/// recorded.
const TABLE: [(u64, usize, bool); 4] = [(901, 1, true), (902, 2, true), (903, 1, false), (904, 2, false)];

/// The cases of the table with their names, four rounds of about eleven: a third of the catalogue
/// each, so that every effect comes at least once and play and stiction in closed loop, where they
/// matter most; one with nothing hidden, a pair, an effect off the catalogue and, where the round
/// has one on a channel that is recorded, an effect on one channel.
#[must_use]
pub fn table() -> Vec<(String, Case)> {
    let mut table = Vec::new();
    for (k, (seed, size, drive)) in TABLE.into_iter().enumerate() {
        let cases = round(seed, size, drive);
        // Thirds 0 and 1 with the drive, 1 and 2 without.
        let third = k - k / 2;
        let singles = cases.iter().filter(|c| c.kind == Kind::Single && c.number % 3 == third);
        let first = |kind: Kind| cases.iter().find(|c| c.kind == kind && exists(&c.arguments));
        let off = cases.iter().find(|c| c.effects == [OFF_CATALOGUE[k]]);
        let chosen = singles
            .chain([Kind::Null, Kind::OneChannel, Kind::Pair].into_iter().filter_map(first))
            .chain(off);
        table.extend(chosen.map(|case| (format!("r{k}c{:03}", case.number), case.clone())));
    }
    table
}

/// Does a short recording have the channels that the arguments name?
fn exists(arguments: &[String]) -> bool {
    let channel = |argument: &String| argument.split_once("@b0c").and_then(|(_, k)| k.parse().ok());
    arguments.iter().filter_map(channel).all(|k: usize| k < SHORT_CHANNELS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_recordings_hide_the_same_on_channels_that_they_have() {
        let cases: Vec<Case> = (1..5).flat_map(|seed| hard(seed, round(seed, 1, true))).collect();
        let short = short(cases.clone());
        for (long, short) in cases.iter().zip(&short) {
            assert_eq!((&long.effects, long.seed), (&short.effects, short.seed));
            assert!(exists(&short.arguments), "{:?}", short.arguments);
            let hard = short.hard.as_ref().expect("a hard case");
            assert!(hard.seconds <= SHORT_S && hard.rate_hz <= 100.0, "{hard:?}");
        }
        assert!(cases.iter().any(|case| !exists(&case.arguments)), "nothing to move");
    }

    #[test]
    fn the_table_hides_every_effect_and_every_kind_in_both_ways() {
        let table = table();
        for drive in [true, false] {
            let of =
                |kind: Kind| table.iter().filter(move |(_, c)| c.drive == drive && c.kind == kind).count();
            assert_eq!([Kind::Null, Kind::Pair, Kind::OffCatalogue, Kind::Single].map(of), [2, 2, 2, 14]);
            assert!(of(Kind::OneChannel) > 0);
        }
        for (id, _) in CATALOGUE {
            let hidden = |(_, case): &&(String, Case)| case.kind == Kind::Single && case.effects[0] == id;
            assert!(table.iter().any(|entry| hidden(&entry)), "{id}");
        }
        let hunts =
            |id: &str| table.iter().any(|(_, c)| !c.drive && c.kind == Kind::Single && c.effects[0] == id);
        assert!(hunts("valve_hysteresis") && hunts("valve_stiction"));
        let names: std::collections::BTreeSet<&String> = table.iter().map(|(name, _)| name).collect();
        assert_eq!(names.len(), table.len());
    }
}
