//! Rollouts against an independent integrator: `tests/oracle/rollouts.py` (SciPy's DOP853 on the
//! equations written once more in Python).

use pneudrive_model::model::{FlowForm, FlowFunction, Linear, Nonlinear, Parametric, ValveDrive, column};
use pneudrive_model::rollout::{Chamber, Series, Start, System, simulate, step_check};

use crate::engine::oracle::Table;

const SPOOL: [f64; 7] = [0.03, 0.05, 4.0, 0.12, -0.09, 0.15, 0.9];
const SEPARATE: [f64; 8] = [0.03, 0.05, 4.0, 6.0, 0.12, 0.2, 0.15, 1.1];
const PARAMETRIC: [f64; 10] = [0.02, 4.0, 2.0, -30.0, 1.5, 0.8, 12.0, 0.1, 0.03, 0.08];
const LINEAR: [f64; 2] = [4.0, 3.5];

fn series(table: &Table, name: &str) -> Series {
    let reference = table.column(name).to_vec();
    let rows = reference.len();
    let inputs = table.inputs(name == "separate");
    #[expect(clippy::single_range_in_vec_init)]
    Series::new(column::COUNT, inputs, reference, vec![1.0; rows], vec![0..rows]).unwrap()
}

/// Largest difference in Pa from the reference.
fn error<Q>(model: Q, parameters: &[f64], name: &str, substeps: usize) -> f64
where
    Chamber<Q>: System,
{
    let series = series(&Table::read("rollouts.csv"), name);
    let outputs = simulate(&Chamber { model, board: None }, parameters, &series, Start::Measured, substeps);
    outputs.iter().zip(series.measured()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn every_model_agrees_with_the_independent_integrator() {
    let printed = Nonlinear { flow: FlowFunction::new(0.3, FlowForm::Printed), ..Nonlinear::default() };
    let separate = Nonlinear { drive: ValveDrive::Separate, ..Nonlinear::default() };
    // Pressures run from 101 to 600 kPa; where the laminar segment is entered within a step the
    // order falls.
    let errors = [
        ("nonlinear", error(Nonlinear::default(), &SPOOL, "nonlinear", 32)),
        ("printed", error(printed, &SPOOL, "printed", 32)),
        ("separate", error(separate, &SEPARATE, "separate", 32)),
        ("parametric", error(Parametric::default(), &PARAMETRIC, "parametric", 32)),
        ("linear", error(Linear::default(), &LINEAR, "linear", 32)),
    ];
    println!("{errors:?}");
    for (name, error) in errors {
        assert!(error < 0.05, "{name}: {error} Pa");
    }
}

#[test]
fn the_reference_reaches_the_laminar_segment() {
    let table = Table::read("rollouts.csv");
    let laminar =
        table.column("nonlinear").iter().filter(|&&p| 101_325.0 / p > FlowFunction::LAMINAR_RATIO).count();
    assert!(laminar > 10, "{laminar} samples");
}

#[test]
fn the_error_falls_with_the_fourth_power_of_the_step() {
    let smooth = |substeps| error(Parametric::default(), &PARAMETRIC, "parametric", substeps);
    let (coarse, fine) = (smooth(1), smooth(2));
    let order = (coarse / fine).log2();
    println!("{coarse} Pa, {fine} Pa, order {order}");
    assert!((3.7..4.4).contains(&order), "order {order}: {coarse} Pa, {fine} Pa");
}

#[test]
fn halving_the_step_predicts_the_error() {
    let series = series(&Table::read("rollouts.csv"), "nonlinear");
    let check = step_check(&Chamber::new(Nonlinear::default()), &SPOOL, &series, Start::Measured, 1);
    let error = error(Nonlinear::default(), &SPOOL, "nonlinear", 1);
    assert!(check.max_pa > 0.7 * error && check.max_pa < 1.3 * error, "{check:?}, error {error} Pa");
}
