//! What can be simulated, fitted and compared, behind one interface whatever the model.

use std::fmt::Debug;
use std::ops::Range;

use super::Chamber;
use super::derivatives;
use super::interval::{self, ActiveLanes, Intervals};
use super::kinds::{
    DIRECTIONS, DualLanes, DualRollout, DualSink, LaneRollout, SENSITIVITY_LANES, WIDE_DIRECTIONS,
};
use super::lanes::{self, Lot};
use super::source::{RowSource, Rows, Steps};
use super::stepper::{ChamberStepper, RowStepper};
use crate::model::{Drive, Model, Parameter};
use crate::numeric::Lanes;

/// A model with what stands in front of it, compiled for every kind of number that simulations and
/// fits are made of.
///
/// The models are generic over their numbers; this trait is where that ends. Each of its methods is
/// compiled once for each model, in this crate, and whoever simulates takes a `&dyn System`: a fit
/// is compiled once, not once a model.
pub trait System: Debug + Send + Sync {
    /// The parameters in the order in which simulations take their values.
    fn parameters(&self) -> Vec<Parameter>;

    /// Ticks in a sample interval of this length, s, at least one: the loops of a board.
    fn ticks(&self, interval_s: f64) -> usize;

    /// Whether the model's rate follows from a row alone: not with a board in front, whose drive is
    /// a result.
    fn has_rates(&self) -> bool;

    /// Simulates rows from an absolute pressure in Pa; `outputs` has an entry per row, absolute,
    /// Pa.
    fn simulate(&self, parameters: &[f64], rows: Rows<'_>, pressure: f64, steps: Steps, outputs: &mut [f64]);

    /// The same with derivatives; `sink` gets each row's number and pressure.
    fn simulate_duals(&self, rollout: DualRollout<'_, DIRECTIONS>, sink: DualSink<'_, DIRECTIONS>);

    /// The same with more derivatives.
    fn simulate_wide(&self, rollout: DualRollout<'_, WIDE_DIRECTIONS>, sink: DualSink<'_, WIDE_DIRECTIONS>);

    /// Rollouts in lockstep, with derivatives; `sink` gets some rows at a time.
    fn simulate_lanes(&self, rollout: LaneRollout<'_>, sink: &mut dyn FnMut(Range<usize>, &[DualLanes]));

    /// Rollouts of a batch in lockstep, without derivatives. Returns whether all inputs were
    /// possible.
    fn simulate_lot(&self, lot: Lot<'_>, outputs: &mut [f64]) -> bool;

    /// The same in single precision.
    fn simulate_lot_single(&self, lot: Lot<'_>, outputs: &mut [f32]) -> bool;

    /// Single intervals in lockstep, with derivatives by inputs, parameters and states.
    fn simulate_intervals(&self, parameters: &[ActiveLanes], steps: Steps, intervals: &mut dyn Intervals);

    /// Rates in Pa/s with their derivatives, at a pressure for each of the rows, one after the
    /// other in `rows`.
    fn rates(
        &self,
        parameters: &[DualLanes],
        rows: &[Lanes<SENSITIVITY_LANES>],
        pressures: &[Lanes<SENSITIVITY_LANES>],
        rates: &mut [DualLanes],
    );

    /// The system with its parameters, to be simulated row by row, at rest at `pressure_pa` in
    /// front of the interval of `row`; `substeps` Runge-Kutta steps are made per tick.
    fn stepper(
        &self,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure_pa: f64,
    ) -> Box<dyn RowStepper>;

    /// The sum of the rates at a pressure for each row, Pa/s: for timing an evaluation of the
    /// right-hand side.
    fn sum_of_rates(&self, parameters: &[f64], rows: Rows<'_>, pressures: &[f64]) -> f64;
}

/// Implements [`System`] for chambers with these models. Not a generic implementation: that would
/// be compiled anew in every crate that names it.
macro_rules! systems {
    ($($model:ident),*) => { $(
        impl System for Chamber<crate::model::$model> {
            fn parameters(&self) -> Vec<Parameter> {
                self.model.parameters()
            }

            fn ticks(&self, interval_s: f64) -> usize {
                Chamber::ticks(self, interval_s)
            }

            fn has_rates(&self) -> bool {
                self.board.is_none()
            }

            fn simulate(&self, parameters: &[f64], rows: Rows<'_>, pressure: f64, steps: Steps, outputs: &mut [f64]) {
                let count = rows.count().min(outputs.len());
                lanes::plain(self, parameters, (rows, count), pressure, steps, outputs);
            }

            fn simulate_duals(&self, rollout: DualRollout<'_, DIRECTIONS>, sink: DualSink<'_, DIRECTIONS>) {
                derivatives::duals(self, rollout, sink);
            }

            fn simulate_wide(&self, rollout: DualRollout<'_, WIDE_DIRECTIONS>, sink: DualSink<'_, WIDE_DIRECTIONS>) {
                derivatives::duals(self, rollout, sink);
            }

            fn simulate_lanes(&self, rollout: LaneRollout<'_>, sink: &mut dyn FnMut(Range<usize>, &[DualLanes])) {
                derivatives::roll_duals(self, rollout, sink);
            }

            fn simulate_lot(&self, lot: Lot<'_>, outputs: &mut [f64]) -> bool {
                lanes::roll_lot(self, lot, outputs)
            }

            fn simulate_lot_single(&self, lot: Lot<'_>, outputs: &mut [f32]) -> bool {
                lanes::roll_lot_single(self, lot, outputs)
            }

            fn simulate_intervals(&self, parameters: &[ActiveLanes], steps: Steps, intervals: &mut dyn Intervals) {
                interval::simulate_intervals(self, parameters, steps, intervals);
            }

            fn rates(
                &self,
                parameters: &[DualLanes],
                rows: &[Lanes<SENSITIVITY_LANES>],
                pressures: &[Lanes<SENSITIVITY_LANES>],
                rates: &mut [DualLanes],
            ) {
                derivatives::rates(&self.model, parameters, rows, pressures, rates);
            }

            fn stepper(
                &self,
                parameters: &[f64],
                substeps: usize,
                row: &[f64],
                pressure_pa: f64,
            ) -> Box<dyn RowStepper> {
                Box::new(ChamberStepper::new(*self, parameters, substeps, row, pressure_pa))
            }

            fn sum_of_rates(&self, parameters: &[f64], rows: Rows<'_>, pressures: &[f64]) -> f64 {
                sum_of_rates(&self.model, parameters, rows, pressures)
            }
        }
    )* };
}

crate::model::for_each_model!(systems);

fn sum_of_rates<Q: Model>(model: &Q, parameters: &[f64], mut rows: Rows<'_>, pressures: &[f64]) -> f64 {
    let coefficients = model.coefficients(parameters);
    let mut sum = 0.0;
    for (k, &pressure) in pressures.iter().enumerate() {
        let row = rows.row(k);
        let held = model.hold(&coefficients, row, Drive::recorded(row));
        sum += model.rate(&coefficients, &held, pressure);
    }
    sum
}
