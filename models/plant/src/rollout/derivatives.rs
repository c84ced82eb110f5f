//! Rollouts with derivatives: alone, and in lockstep.

use std::ops::Range;

use multiversion::multiversion;
use multiversion::target::match_target;

use super::Chamber;
use super::kinds::{DIRECTIONS, DualLanes, DualRollout, DualSink, LaneRollout, SENSITIVITY_LANES};
use super::run::rollout;
use super::source::Rows;
use crate::model::{Drive, Model, column};
use crate::numeric::{Dual, Lanes, Scalar};

/// Rows of rollouts with derivatives that are handed on at a time.
const ROWS: usize = 16;

/// One rollout with derivatives. Each number of them is compiled once for each model.
#[inline(never)]
pub(super) fn duals<Q: Model, const W: usize>(
    chamber: &Chamber<Q>,
    DualRollout { parameters, rows, pressure, steps }: DualRollout<'_, W>,
    sink: DualSink<'_, W>,
) {
    let coefficients = chamber.model.coefficients(parameters);
    rollout(chamber, &coefficients, (rows, rows.count()), pressure, steps, |k, y| sink(k, &y));
}

/// Rollouts with derivatives; `sink` gets the numbers of some rows and the pressures there.
///
/// As of lots, there is no version in lanes for the oldest processors.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn roll_duals<Q: Model>(
    chamber: &Chamber<Q>,
    rollout: LaneRollout<'_>,
    sink: &mut dyn FnMut(Range<usize>, &[DualLanes]),
) {
    match_target! {
        "x86_64+avx512f" => duals_side_by_side(chamber, rollout, sink),
        "x86_64+avx2" => duals_side_by_side(chamber, rollout, sink),
        "x86_64" => duals_one_by_one(chamber, rollout, sink),
        _ => duals_side_by_side(chamber, rollout, sink),
    }
}

fn duals_one_by_one<Q: Model>(
    chamber: &Chamber<Q>,
    LaneRollout { parameters, rows, count, pressure, steps }: LaneRollout<'_>,
    sink: &mut dyn FnMut(Range<usize>, &[DualLanes]),
) {
    let alone = |number: &DualLanes, lane: usize| -> Dual<f64, DIRECTIONS> {
        Dual { value: number.value.0[lane], gradient: number.gradient.map(|slope| slope.0[lane]) }
    };
    let mut table = Vec::new();
    (0..count).for_each(|k| table.extend_from_slice(rows.row(k)));
    let mut pressures = vec![DualLanes::constant(0.0); count];
    for lane in 0..SENSITIVITY_LANES {
        let parameters: Vec<_> = parameters.iter().map(|number| alone(number, lane)).collect();
        let inputs: Vec<f64> = table.iter().map(|number| number.0[lane]).collect();
        let rows = Rows { inputs: &inputs, width: table.len() / count.max(1) };
        let rollout = DualRollout { parameters: &parameters, rows, pressure: alone(&pressure, lane), steps };
        duals(chamber, rollout, &mut |k, y: &Dual<f64, DIRECTIONS>| {
            pressures[k].value.0[lane] = y.value;
            for (slope, of_lane) in pressures[k].gradient.iter_mut().zip(y.gradient) {
                slope.0[lane] = of_lane;
            }
        });
    }
    for (block, pressures) in pressures.chunks(ROWS).enumerate() {
        sink(block * ROWS..block * ROWS + pressures.len(), pressures);
    }
}

#[inline(always)]
fn duals_side_by_side<Q: Model>(
    chamber: &Chamber<Q>,
    LaneRollout { parameters, rows, count, pressure, steps }: LaneRollout<'_>,
    sink: &mut dyn FnMut(Range<usize>, &[DualLanes]),
) {
    let mut block = [DualLanes::constant(0.0); ROWS];
    rollout(
        chamber,
        &chamber.model.coefficients(parameters),
        (rows, count),
        pressure,
        steps,
        #[inline(always)]
        |k, y| {
            let at = k % ROWS;
            block[at] = y;
            if at == ROWS - 1 || k + 1 == count {
                sink(k - at..k + 1, &block[..=at]);
            }
        },
    );
}

/// Rates at a pressure for each of the rows.
pub(super) fn rates<Q: Model>(
    model: &Q,
    parameters: &[DualLanes],
    rows: &[Lanes<SENSITIVITY_LANES>],
    pressures: &[Lanes<SENSITIVITY_LANES>],
    rates: &mut [DualLanes],
) {
    let coefficients = model.coefficients(parameters);
    let width = rows.len() / pressures.len().max(1);
    debug_assert!(pressures.is_empty() || width >= column::COUNT, "a row has the standard columns");
    for ((row, &pressure), rate) in rows.chunks_exact(width.max(1)).zip(pressures).zip(rates) {
        rate_of(model, &coefficients, row, pressure, rate);
    }
}

/// One row at a time: the compiler makes a loop over rows anew for each form of the model, each of
/// them slower than this call.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn rate_of<Q: Model>(
    model: &Q,
    coefficients: &Q::Coefficients<DualLanes>,
    row: &[Lanes<SENSITIVITY_LANES>],
    pressure: Lanes<SENSITIVITY_LANES>,
    rate: &mut DualLanes,
) {
    let held = model.hold(coefficients, row, Drive::recorded(row));
    *rate = model.rate(coefficients, &held, DualLanes::from_real(pressure));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Nonlinear, nominal_values};
    use crate::numeric::Real;
    use crate::rollout::{GatheredRows, Steps};

    /// What old processors do is what wide vectors do, to the bit.
    #[test]
    fn one_by_one_rollouts_have_the_derivatives_that_they_have_side_by_side() {
        const COUNT: usize = 2 * ROWS + 3;
        let chamber = Chamber::new(Nonlinear::default());
        let nominal = nominal_values(&chamber.model.parameters());
        let varied = |i: usize| Lanes::from_lanes(|lane| nominal[i] * (1.0 + 0.1 * lane as f64));
        let parameters: Vec<DualLanes> = (0..nominal.len()).map(|i| Dual::variable(varied(i), i)).collect();
        let mut inputs = vec![0.0; COUNT * column::COUNT];
        for (k, row) in inputs.chunks_exact_mut(column::COUNT).enumerate() {
            let u = 0.5 * (0.3 * k as f64).sin();
            row[column::INTERVAL_S] = 0.01;
            (row[column::FILL], row[column::VENT]) = (u, -u);
            row[column::SUPPLY_PA] = 6e5;
            row[column::INVERSE_VOLUME_PER_M3] = 1.0 / 3.6e-4;
        }
        let outputs = |one_by_one: bool| {
            let mut rows =
                GatheredRows::<SENSITIVITY_LANES>::new([&inputs; SENSITIVITY_LANES], column::COUNT);
            let rollout = LaneRollout {
                parameters: &parameters,
                rows: &mut rows,
                count: COUNT,
                pressure: DualLanes::constant(2e5),
                steps: Steps { ticks: 1, substeps: 2 },
            };
            let mut outputs = Vec::new();
            let mut sink = |rows: Range<usize>, pressures: &[DualLanes]| {
                assert_eq!(rows, outputs.len()..outputs.len() + pressures.len());
                outputs.extend_from_slice(pressures);
            };
            if one_by_one {
                duals_one_by_one(&chamber, rollout, &mut sink);
            } else {
                duals_side_by_side(&chamber, rollout, &mut sink);
            }
            outputs
        };
        let alone = outputs(true);
        assert_eq!(alone.len(), COUNT);
        assert_eq!(alone, outputs(false));
        assert!(alone[COUNT - 1].gradient[2].0[3].abs() > 1.0, "nothing depends on the gain");
    }
}
