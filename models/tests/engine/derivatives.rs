//! Sensitivities of rollouts against central differences.

use pneudrive_model::board::{Arithmetic, Board, Controller, Sensor};
use pneudrive_model::model::{Linear, Model, Nonlinear, Parametric, ValveDrive, column};
use pneudrive_model::numeric::{Dual, Scalar};
use pneudrive_model::rollout::{Chamber, Rows, Steps, rollout};

use crate::engine::support;

const ROWS: usize = 400;
const START_PA: f64 = 250e3;

fn run<S: Scalar<Real = f64>, Q: Model>(chamber: &Chamber<Q>, parameters: &[S], inputs: &[f64]) -> Vec<S> {
    let mut outputs = Vec::with_capacity(ROWS);
    let rows = (Rows { inputs, width: column::COUNT }, ROWS);
    let steps = Steps { ticks: chamber.ticks(0.01), substeps: 2 };
    let coefficients = chamber.model.coefficients(parameters);
    rollout(chamber, &coefficients, rows, S::constant(START_PA), steps, |_, y| outputs.push(y));
    outputs
}

fn check<Q: Model>(name: &str, chamber: &Chamber<Q>, parameters: &[f64]) {
    let inputs = support::inputs(ROWS, 5);
    let duals: Vec<Dual<f64, 12>> =
        parameters.iter().enumerate().map(|(i, &value)| Dual::variable(value, i)).collect();
    let exact = run(chamber, &duals, &inputs);
    let plain = run(chamber, parameters, &inputs);
    assert!(exact.iter().zip(&plain).all(|(dual, value)| dual.value == *value), "{name}: values differ");
    for i in 0..parameters.len() {
        let h = 1e-5 * parameters[i].abs().max(0.1);
        let moved = |sign: f64| {
            let mut moved = parameters.to_vec();
            moved[i] += sign * h;
            run(chamber, &moved, &inputs)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        let largest = exact.iter().map(|dual| dual.gradient[i].abs()).fold(0.0, f64::max);
        assert!(largest > 1.0, "{name}: parameter {i} has no effect");
        for (k, dual) in exact.iter().enumerate() {
            let difference = (up[k] - down[k]) / (2.0 * h);
            let error = (dual.gradient[i] - difference).abs();
            assert!(
                error < 2e-5 * largest,
                "{name}: parameter {i}, row {k}: {} {difference}",
                dual.gradient[i]
            );
        }
    }
}

#[test]
fn every_model_is_differentiated_exactly() {
    let separate = Nonlinear { drive: ValveDrive::Separate, ..Nonlinear::default() };
    let parametric = [0.02, 4.0, 2.0, -30.0, 1.5, 0.8, 12.0, 0.1, 0.03, 0.08];
    check("nonlinear", &Chamber::new(Nonlinear::default()), &support::TRUTH);
    check("separate", &Chamber::new(separate), &[0.03, 0.05, 4.0, 6.0, 0.12, 0.1, 0.15, 1.1]);
    check("parametric", &Chamber::new(Parametric::default()), &parametric);
    check("linear", &Chamber::new(Linear::default()), &[4.0, 3.5]);
}

/// In closed loop, with a converter so fine that rounding is far below the differences taken.
#[test]
fn the_boards_loop_is_differentiated_exactly() {
    // Counts of a micropascal, so the gains are per 1e-6 Pa.
    let controller = Controller { rate_hz: 200.0, kp: 3e-11, kd: 2e-11, saturation: 1.0, filter: 0.82 };
    let sensor = Sensor { bits: 52, zero_counts: 1e6, kpa_per_count: 1e-9 };
    let board = Board { controller, arithmetic: Arithmetic::Fine, sensor, ambient_pa: 101_325.0 };
    check("board", &Chamber::behind(Nonlinear::default(), board), &support::TRUTH);
}

/// A bound of the box is not the end of the physics: no model may fail at its nominal values or at
/// its bounds' corner.
#[test]
fn nominal_parameters_give_finite_sensitivities() {
    fn finite<Q: Model>(model: Q) {
        let name = model.name();
        let inputs = support::inputs(ROWS, 6);
        let nominal = pneudrive_model::model::nominal_values(&model.parameters());
        let duals: Vec<Dual<f64, 12>> =
            nominal.iter().enumerate().map(|(i, &value)| Dual::variable(value, i)).collect();
        let outputs = run(&Chamber::new(model), &duals, &inputs);
        let finite =
            |dual: &Dual<f64, 12>| dual.value.is_finite() && dual.gradient.iter().all(|g| g.is_finite());
        assert!(outputs.iter().all(finite), "{name}");
    }
    finite(Linear::default());
    finite(Nonlinear::default());
    finite(Parametric::default());
}
