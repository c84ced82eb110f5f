//! Derivatives of rollouts of extended models by their inputs: those of central differences, for
//! every effect and everything that drives a channel.

use crate::support::{Driven, STEP_S, extended, generator};
use pneudrive_model::diagnosis::{ExtendedFile, ExtendedRollouts};
use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::model::column;
use pneudrive_model::rollout::{BatchColumn, BatchInputs, BatchResults, BatchUnit, DIFFERENTIATED, Job};
use rand::RngExt;

/// More than are differentiated in one stretch.
const ROWS: usize = 300;
const ROLLOUTS: usize = 2;
const START_PA: f64 = 1.6e5;

/// Columns that a channel follows.
fn followed(driven: Driven) -> Vec<usize> {
    let mut columns = match driven {
        Driven::Spool => vec![column::FILL],
        Driven::Separate => vec![column::FILL, column::VENT],
        Driven::Board | Driven::Command => vec![column::COMMAND_PA],
    };
    if driven != Driven::Command {
        columns.extend([column::SUPPLY_PA, column::INVERSE_VOLUME_PER_M3, column::VOLUME_RATE_M3_S]);
    }
    columns
}

/// Random inputs, `[column][rollout][row]`: drives and set points that jump, the rest smooth.
fn columns(seed: u64) -> Vec<Vec<f64>> {
    let mut rng = generator(seed);
    let mut jumping = |low: f64, high: f64| {
        let mut values = Vec::new();
        while values.len() < ROLLOUTS * ROWS {
            let (hold, level) = (rng.random_range(5..40), rng.random_range(low..high));
            values.extend(std::iter::repeat_n(level, hold));
        }
        values.truncate(ROLLOUTS * ROWS);
        values
    };
    let smooth = |mean: f64, swing: f64, per_row: f64| -> Vec<f64> {
        (0..ROLLOUTS * ROWS).map(|k| mean + swing * (per_row * k as f64).sin()).collect()
    };
    let mut columns = vec![Vec::new(); column::COUNT];
    columns[column::INTERVAL_S] = vec![STEP_S; ROLLOUTS * ROWS];
    columns[column::TIME_S] = vec![0.0; ROLLOUTS * ROWS];
    columns[column::FILL] = jumping(0.05, 0.6);
    columns[column::VENT] = jumping(0.05, 0.6);
    columns[column::COMMAND_PA] = jumping(1.5e5, 3.5e5);
    columns[column::SUPPLY_PA] = smooth(6.2e5, 2e4, 0.05);
    columns[column::INVERSE_VOLUME_PER_M3] = smooth(5e3, 5e2, 0.03);
    columns[column::VOLUME_RATE_M3_S] = smooth(0.0, 1e-5, 0.04);
    columns
}

fn inputs(columns: &[Vec<f64>]) -> BatchInputs<'_> {
    let columns = columns.iter().map(BatchColumn::per_job_and_row).collect();
    BatchInputs::new(columns, ROLLOUTS, ROWS).unwrap()
}

/// A channel whose derivatives are tried.
struct Tried {
    rollouts: ExtendedRollouts,
    columns: Vec<Vec<f64>>,
    weights: Vec<f64>,
}

impl Tried {
    fn new(file: &ExtendedFile, driven: Driven, seed: u64) -> Self {
        let rollouts = ExtendedRollouts::new("extended model", file, "b0c0".parse().unwrap(), None).unwrap();
        let mut columns = columns(seed);
        if driven == Driven::Spool {
            // Both ways.
            columns[column::FILL].iter_mut().for_each(|drive| *drive = 2.0 * (*drive - 0.32));
        }
        let weights = (0..ROLLOUTS * ROWS).map(|k| (0.7 * k as f64).sin() + 0.3).collect();
        Self { rollouts, columns, weights }
    }

    fn jobs(&self) -> Vec<Job<'_>> {
        vec![Job { parameters: self.rollouts.values(), start: START_PA }; ROLLOUTS]
    }

    /// The weighted sum of the pressures, Pa.
    fn sum(&self, columns: &[Vec<f64>]) -> f64 {
        let mut outputs = vec![0.0; ROLLOUTS * ROWS];
        let unit = BatchUnit { zero_pa: 0.0, per_pa: 1.0 };
        let results = BatchResults { outputs: &mut outputs, sensitivities: None, unit };
        self.rollouts.simulate(&self.jobs(), &inputs(columns), results).unwrap();
        outputs.iter().zip(&self.weights).map(|(pressure, weight)| pressure * weight).sum()
    }

    /// The derivatives that differ from differences to either side, of those by some rows of these
    /// columns, and how many were compared.
    fn apart(&self, followed: &[usize], seed: u64) -> (Vec<String>, usize) {
        let found = self.rollouts.gradient(&self.jobs(), &inputs(&self.columns), &self.weights).unwrap();
        let mut rng = generator(seed);
        let (mut apart, mut compared) = (Vec::new(), 0);
        for (slot, &column) in DIFFERENTIATED.iter().enumerate() {
            let slopes = &found.inputs[slot];
            assert_eq!(slopes.len(), ROLLOUTS * ROWS);
            let most = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
            if !followed.contains(&column) {
                assert_eq!(most, 0.0, "column {column} drives nothing");
                continue;
            }
            assert!(most > 0.0, "column {column} drives something");
            assert_eq!(slopes[ROWS - 1], 0.0, "nothing follows the last row");
            let scale = self.columns[column].iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            let step = 1e-7 * scale;
            for _ in 0..6 {
                let at = rng.random_range(0..ROLLOUTS * ROWS);
                let moved = |sign: f64| {
                    let mut columns = self.columns.clone();
                    columns[column][at] += sign * step;
                    self.sum(&columns)
                };
                let [before, here, behind] = [-1.0, 0.0, 1.0].map(moved);
                // On a kink, and friction stands on one wherever a drive is held, the slope to
                // either side is right.
                let sides = [(here - before) / step, (behind - here) / step];
                let (low, high) = (sides[0].min(sides[1]), sides[0].max(sides[1]));
                compared += 1;
                if !(low - 1e-3 * most..=high + 1e-3 * most).contains(&slopes[at]) {
                    apart.push(format!("column {column} at {at}: {} for {sides:?}", slopes[at]));
                }
            }
        }
        (apart, compared)
    }
}

/// Effects with memories of several kinds, in their largest probe: every derivative is that of
/// differences.
#[test]
fn smooth_models_are_differentiated_exactly() {
    let effects = ["valve_lag", "vent_restriction", "wall_creep", "line_restriction", "sensor_lag"];
    for driven in [Driven::Spool, Driven::Separate, Driven::Board] {
        let mut file = extended(&mut generator(31 + driven as u64), driven, 1, &effects);
        for (id, values) in &mut file.channels.get_mut("b0c0").unwrap().effects {
            let info = CATALOGUE.iter().find(|info| info.id == id).unwrap();
            let probe = info.probes.last().unwrap();
            *values = info.parameters.iter().zip(*probe).map(|(p, v)| (p.name.to_owned(), *v)).collect();
        }
        let (apart, compared) = Tried::new(&file, driven, 5).apart(&followed(driven), 6);
        assert!(compared >= 20 && apart.is_empty(), "{driven:?}: {apart:?}");
    }
}

/// Ports that close, flows that choke and friction have kinks; elsewhere the derivatives are those
/// of differences.
#[test]
fn every_effect_is_differentiated_by_its_inputs() {
    let (mut all, mut total) = (Vec::new(), 0);
    for (number, info) in CATALOGUE.iter().enumerate() {
        for driven in Driven::ALL.into_iter().filter(|driven| driven.has(info)) {
            let seed = 100 * number as u64 + driven as u64;
            let file = extended(&mut generator(seed), driven, 1, &[info.id]);
            let (apart, compared) = Tried::new(&file, driven, seed + 1).apart(&followed(driven), seed + 2);
            assert!(2 * apart.len() <= compared, "{} {driven:?}: {apart:?}", info.id);
            all.extend(apart.into_iter().map(|one| format!("{} {driven:?} {one}", info.id)));
            total += compared;
        }
    }
    println!("{} of {total} are apart: {all:#?}", all.len());
    assert!(total > 1000 && 50 * all.len() < total, "{} of {total}: {all:#?}", all.len());
}
