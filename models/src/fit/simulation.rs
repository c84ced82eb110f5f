//! Residuals of rollouts: simulated minus measured pressure.

use std::ops::Range;

use nalgebra::DVector;

use super::jacobian::Jacobian;
use super::lockstep::{self, KPA_PER_PA, LaneSums};
use super::normal::Accumulator;
use super::{Normal, Objective, Space};
use crate::numeric::{Dual, Lanes, Real, Scalar};
use crate::parallel;
use crate::rollout::{
    DIRECTIONS, DualLanes, DualRollout, GatheredRows, LaneRollout, Rows, SENSITIVITY_LANES, Series, Steps,
    System, WIDE_DIRECTIONS,
};

/// Bounds of a fitted start pressure, absolute, kPa.
const START_BOUNDS_KPA: (f64, f64) = (1.0, 1e5);

/// How the pressure at the start of each segment is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartPressure {
    /// It is the first usable measurement.
    Measured,
    /// It is one more unknown per segment, started at the first usable measurement.
    #[default]
    Fitted,
}

/// Sum of the squared differences in kPa between a system's rollouts and the measurements, over all
/// segments.
///
/// Coordinates: the free parameters, then, if fitted, the start pressures (kPa absolute) of segment
/// 0, 1, ...
#[derive(Debug)]
pub struct RolloutObjective<'a> {
    system: &'a dyn System,
    series: &'a Series,
    space: Space,
    start: StartPressure,
    steps: Steps,
    free: usize,
    /// Segments by length, longest first, so that lanes are filled evenly.
    order: Vec<usize>,
}

impl<'a> RolloutObjective<'a> {
    /// The residuals of `series` with the parameters of `space`.
    #[must_use]
    pub fn new(
        system: &'a dyn System,
        series: &'a Series,
        space: Space,
        start: StartPressure,
        substeps: usize,
    ) -> Self {
        let steps = Steps { ticks: system.ticks(series.interval_s()), substeps };
        let mut order: Vec<usize> = (0..series.segments().len()).collect();
        order.sort_by_key(|&segment| std::cmp::Reverse(series.segments()[segment].len()));
        let free = space.free_count();
        Self { system, series, space, start, steps, free, order }
    }

    fn fitted_starts(&self) -> bool {
        self.start == StartPressure::Fitted
    }

    /// Directions of one rollout: the free parameters and its own start pressure.
    #[must_use]
    pub fn directions(&self) -> usize {
        self.free + usize::from(self.fitted_starts())
    }

    /// Absolute start pressure in Pa of each segment.
    #[must_use]
    pub fn start_pressures(&self, coordinates: &[f64]) -> Vec<f64> {
        if !self.fitted_starts() {
            return self.series.starts().to_vec();
        }
        coordinates[self.free..].iter().map(|start| start / KPA_PER_PA).collect()
    }

    /// Coordinates of the directions of a segment's rollout.
    fn indices(&self, segment: usize) -> Vec<usize> {
        let own = self.fitted_starts().then_some(self.free + segment);
        (0..self.free).chain(own).collect()
    }

    /// Start pressure in Pa, with its direction when it is fitted.
    fn start_dual<R: Real, const W: usize>(&self, pressure: R, first: usize) -> Dual<R, W> {
        if self.fitted_starts() {
            Dual::variable(pressure.times(KPA_PER_PA), self.free.wrapping_sub(first)).times(1.0 / KPA_PER_PA)
        } else {
            Dual::from_real(pressure)
        }
    }

    /// The sums of a few segments, in lockstep where that is compiled.
    fn group_normal(&self, coordinates: &[f64], segments: &[usize]) -> Normal {
        let starts = self.start_pressures(coordinates);
        let mut normal = Normal::zeros(self.dimension());
        if segments.len() > 1 && self.directions() <= DIRECTIONS {
            let sums = self.lockstep(coordinates, segments, &starts);
            for (lane, &segment) in segments.iter().enumerate() {
                sums.scatter(lane, &self.indices(segment), &mut normal);
            }
            return normal;
        }
        for &segment in segments {
            let place = Place { segment, pressure: starts[segment], first: 0 };
            if self.directions() <= DIRECTIONS {
                self.sum::<DIRECTIONS>(coordinates, place, &mut normal);
            } else if self.directions() <= WIDE_DIRECTIONS {
                self.sum::<WIDE_DIRECTIONS>(coordinates, place, &mut normal);
            } else {
                self.jacobian(coordinates, place).add_to(&self.indices(segment), &mut normal);
            }
        }
        normal
    }

    /// The sums of up to as many segments as there are lanes.
    fn lockstep(&self, coordinates: &[f64], segments: &[usize], starts: &[f64]) -> LaneSums {
        let of = |lane: usize| segments[lane.min(segments.len() - 1)];
        let ranges: Vec<Range<usize>> =
            segments.iter().map(|&segment| self.series.segments()[segment].clone()).collect();
        let inputs = std::array::from_fn(|lane| self.series.inputs(self.series.segments()[of(lane)].clone()));
        let mut rows = GatheredRows::<SENSITIVITY_LANES>::new(inputs, self.series.width());
        let pressure = Lanes::from_lanes(|lane| starts[of(lane)]);
        let parameters: Vec<DualLanes> = self.space.duals(coordinates, 0);
        let rollout = LaneRollout {
            parameters: &parameters,
            rows: &mut rows,
            count: ranges.iter().map(Range::len).max().unwrap_or(0),
            pressure: self.start_dual(pressure, 0),
            steps: self.steps,
        };
        let mut sums = LaneSums::new();
        self.system.simulate_lanes(rollout, &mut |rows, pressures| {
            lockstep::add_rows(&mut sums, (self.series, &ranges), rows.start, pressures);
        });
        sums
    }

    fn sum<const W: usize>(&self, coordinates: &[f64], place: Place, normal: &mut Normal)
    where
        Dual<f64, W>: Compiled<W>,
    {
        let mut sums = Accumulator::<f64, W>::new();
        self.single(coordinates, place, &mut |_, residual: &Dual<f64, W>| sums.add(residual));
        sums.scatter(0, &self.indices(place.segment), normal);
    }

    /// One segment's residuals with `W` of their derivatives.
    fn single<const W: usize>(
        &self,
        coordinates: &[f64],
        place: Place,
        sink: &mut dyn FnMut(usize, &Dual<f64, W>),
    ) where
        Dual<f64, W>: Compiled<W>,
    {
        let range = &self.series.segments()[place.segment];
        let parameters: Vec<Dual<f64, W>> = self.space.duals(coordinates, place.first);
        let rollout = DualRollout {
            parameters: &parameters,
            rows: Rows { inputs: self.series.inputs(range.clone()), width: self.series.width() },
            pressure: self.start_dual(place.pressure, place.first),
            steps: self.steps,
        };
        let (measured, weights) =
            (&self.series.measured()[range.clone()], &self.series.weights()[range.clone()]);
        Dual::simulate(self.system, rollout, &mut |k, pressure| {
            // A masked sample weighs nothing.
            let (measured, weight) = if weights[k] > 0.0 { (measured[k], weights[k]) } else { (0.0, 0.0) };
            sink(k, &(*pressure - Dual::from_real(measured)).scale(weight * KPA_PER_PA));
        });
    }

    /// One segment's residuals with all of their derivatives, by as many simulations as it takes.
    fn jacobian(&self, coordinates: &[f64], place: Place) -> Jacobian {
        let directions = self.directions();
        let count = self.series.segments()[place.segment].len();
        let mut jacobian =
            Jacobian { directions, residuals: vec![0.0; count], slopes: vec![0.0; count * directions] };
        if directions <= DIRECTIONS {
            self.fill::<DIRECTIONS>(coordinates, place, &mut jacobian);
        } else {
            for first in (0..directions).step_by(WIDE_DIRECTIONS) {
                self.fill::<WIDE_DIRECTIONS>(coordinates, Place { first, ..place }, &mut jacobian);
            }
        }
        jacobian
    }

    fn fill<const W: usize>(&self, coordinates: &[f64], place: Place, jacobian: &mut Jacobian)
    where
        Dual<f64, W>: Compiled<W>,
    {
        let directions = place.first..jacobian.directions.min(place.first + W);
        self.single(coordinates, place, &mut |k, residual: &Dual<f64, W>| {
            jacobian.residuals[k] = residual.value;
            let row = &mut jacobian.slopes[k * jacobian.directions..][directions.clone()];
            row.copy_from_slice(&residual.gradient[..directions.len()]);
        });
    }
}

/// Which segment is simulated from where (absolute, Pa), and which direction comes first.
#[derive(Debug, Clone, Copy)]
struct Place {
    segment: usize,
    pressure: f64,
    first: usize,
}

/// Numbers of directions that systems are compiled for.
trait Compiled<const W: usize> {
    fn simulate(system: &dyn System, rollout: DualRollout<'_, W>, sink: &mut dyn FnMut(usize, &Dual<f64, W>));
}

impl Compiled<DIRECTIONS> for Dual<f64, DIRECTIONS> {
    fn simulate(
        system: &dyn System,
        rollout: DualRollout<'_, DIRECTIONS>,
        sink: &mut dyn FnMut(usize, &Self),
    ) {
        system.simulate_duals(rollout, sink);
    }
}

impl Compiled<WIDE_DIRECTIONS> for Dual<f64, WIDE_DIRECTIONS> {
    fn simulate(
        system: &dyn System,
        rollout: DualRollout<'_, WIDE_DIRECTIONS>,
        sink: &mut dyn FnMut(usize, &Self),
    ) {
        system.simulate_wide(rollout, sink);
    }
}

impl Objective for RolloutObjective<'_> {
    fn dimension(&self) -> usize {
        self.free + if self.fitted_starts() { self.series.segments().len() } else { 0 }
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        let mut bounds = self.space.bounds();
        bounds.resize(self.dimension(), START_BOUNDS_KPA);
        bounds
    }

    fn nominal(&self) -> Vec<f64> {
        let mut nominal = self.space.nominal();
        if self.fitted_starts() {
            nominal.extend(self.series.starts().iter().map(|pressure| pressure * KPA_PER_PA));
        }
        nominal
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let parts: Vec<Normal> = parallel::map(self.order.chunks(SENSITIVITY_LANES), |segments| {
            self.group_normal(coordinates, segments)
        });
        // Summed in a fixed order: the result does not depend on the number of threads.
        let mut normal = Normal::zeros(self.dimension());
        for part in parts {
            normal.cost += part.cost;
            normal.gradient += part.gradient;
            normal.matrix += part.matrix;
        }
        normal
    }

    fn residuals(&self) -> usize {
        self.series.usable()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        let starts = self.start_pressures(coordinates);
        for (segment, &pressure) in starts.iter().enumerate() {
            let indices = self.indices(segment);
            let jacobian = self.jacobian(coordinates, Place { segment, pressure, first: 0 });
            let mut score = DVector::zeros(self.dimension());
            let rows = jacobian.residuals.iter().zip(jacobian.slopes.chunks_exact(indices.len()));
            for (residual, slopes) in rows {
                score.fill(0.0);
                for (&index, slope) in indices.iter().zip(slopes) {
                    score[index] = slope * residual;
                }
                sink(segment, &score, residual * residual);
            }
        }
    }
}
