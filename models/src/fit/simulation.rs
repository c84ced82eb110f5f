//! Residuals of rollouts: simulated minus measured pressure.

use std::ops::Range;

use multiversion::multiversion;
use nalgebra::DVector;
use rayon::prelude::*;

use super::jacobian::Jacobian;
use super::normal::Accumulator;
use super::{Normal, Objective, Space};
use crate::numeric::{Dual, Lanes, Real, Scalar, filled};
use crate::rollout::{GatheredRows, RowSource, Rows, Series, Steps, System, rollout};

/// Segments simulated in lockstep when there are several.
const LANES: usize = 4;

/// Derivatives computed at a time: enough for most fits, or for most that have more.
const NARROW: usize = 8;
const WIDE: usize = 12;

/// Residuals are in kPa.
const KPA_PER_PA: f64 = 1e-3;

/// Bounds of a fitted start pressure, absolute, kPa.
const START_BOUNDS_KPA: (f64, f64) = (1.0, 1e5);

/// How the pressure at the start of each segment is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartPressure {
    /// It is the first usable measurement.
    Measured,
    /// It is one more unknown per segment and output, started at the first usable measurement.
    #[default]
    Fitted,
}

/// Sum of the squared differences in kPa between a system's rollouts and the measurements, over all segments.
///
/// Coordinates: the free parameters, then, if fitted, the start pressures (kPa absolute) of segment 0, 1, ...
#[derive(Debug)]
pub struct RolloutObjective<'a, Y, const N: usize, const M: usize> {
    system: &'a Y,
    series: &'a Series<M>,
    space: Space,
    start: StartPressure,
    steps: Steps,
    free: usize,
    /// Segments by length, longest first, so that lanes are filled evenly.
    order: Vec<usize>,
}

impl<'a, Y: System<N, M>, const N: usize, const M: usize> RolloutObjective<'a, Y, N, M> {
    /// The residuals of `series` with the parameters of `space`.
    pub fn new(
        system: &'a Y,
        series: &'a Series<M>,
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

    /// Directions of one rollout: the free parameters and its own start pressures.
    #[must_use]
    pub fn directions(&self) -> usize {
        self.free + if self.fitted_starts() { M } else { 0 }
    }

    /// Absolute start pressures in Pa of each segment.
    #[must_use]
    pub fn start_pressures(&self, coordinates: &[f64]) -> Vec<[f64; M]> {
        if !self.fitted_starts() {
            return self.series.starts().to_vec();
        }
        let starts = coordinates[self.free..].chunks_exact(M);
        starts.map(|start| std::array::from_fn(|output| start[output] / KPA_PER_PA)).collect()
    }

    /// Coordinates of the directions of a segment's rollout.
    fn indices(&self, segment: usize) -> Vec<usize> {
        let own = self.free + segment * M;
        let starts = if self.fitted_starts() { own..own + M } else { 0..0 };
        (0..self.free).chain(starts).collect()
    }

    /// Start pressures in Pa, with their directions when they are fitted.
    #[inline(always)]
    fn start_duals<R: Real, const W: usize>(&self, pressures: [R; M], first: usize) -> [Dual<R, W>; M] {
        filled(
            Dual::constant(0.0),
            #[inline(always)]
            |output| {
                if self.fitted_starts() {
                    Dual::variable(
                        pressures[output].times(KPA_PER_PA),
                        (self.free + output).wrapping_sub(first),
                    )
                    .times(1.0 / KPA_PER_PA)
                } else {
                    Dual::from_real(pressures[output])
                }
            },
        )
    }

    /// Residuals of several rollouts in lockstep, weighted; `sink` gets the row's number and each output's
    /// residual with its derivatives in the directions from `first`.
    #[inline(always)]
    fn stream<R: Real, const W: usize>(
        &self,
        (coordinates, first): (&[f64], usize),
        source: impl RowSource<R>,
        segments: &[Range<usize>],
        pressures: [R; M],
        mut sink: impl FnMut(usize, &[Dual<R, W>; M]),
    ) {
        let coefficients = self.system.coefficients(&self.space.duals::<R, W>(coordinates, first));
        let count = segments.iter().map(Range::len).max().unwrap_or(0);
        let (measured, weights) = (self.series.measured(), self.series.weights());
        rollout(
            self.system,
            &coefficients,
            (source, count),
            self.start_duals(pressures, first),
            self.steps,
            #[inline(always)]
            |k, outputs: &[Dual<R, W>; M]| {
                let residuals = filled(
                    Dual::constant(0.0),
                    #[inline(always)]
                    |output| {
                        // A lane whose segment is over, or whose sample is masked, weighs nothing.
                        let row = |lane: usize| {
                            let rows = segments.get(lane).filter(|rows| k < rows.len())?;
                            Some(rows.start + k).filter(|&row| weights[row][output] > 0.0)
                        };
                        let target = R::from_lanes(
                            #[inline(always)]
                            |lane| row(lane).map_or(0.0, |row| measured[row][output]),
                        );
                        let weight = R::from_lanes(
                            #[inline(always)]
                            |lane| row(lane).map_or(0.0, |row| weights[row][output]),
                        );
                        (outputs[output] - Dual::from_real(target)).scale(weight.times(KPA_PER_PA))
                    },
                );
                sink(k, &residuals);
            },
        );
    }

    /// The sums of a few segments, in lockstep where that is compiled.
    fn group_normal(&self, coordinates: &[f64], segments: &[usize]) -> Normal {
        let starts = self.start_pressures(coordinates);
        let mut normal = Normal::zeros(self.dimension());
        if segments.len() > 1 && self.directions() <= NARROW {
            let sums = lockstep_sums::<Y, NARROW, N, M>(self, coordinates, segments, &starts);
            for (lane, &segment) in segments.iter().enumerate() {
                sums.scatter(lane, &self.indices(segment), &mut normal);
            }
            return normal;
        }
        for &segment in segments {
            let place = Place { segment, pressures: starts[segment], first: 0 };
            if self.directions() <= NARROW {
                self.sum::<NARROW>(coordinates, place, &mut normal);
            } else if self.directions() <= WIDE {
                self.sum::<WIDE>(coordinates, place, &mut normal);
            } else {
                self.jacobian(coordinates, place).add_to(&self.indices(segment), &mut normal);
            }
        }
        normal
    }

    fn sum<const W: usize>(&self, coordinates: &[f64], place: Place<M>, normal: &mut Normal) {
        let mut sums = Accumulator::<f64, W>::new();
        self.single(coordinates, place, &mut |_, residuals: &[Dual<f64, W>; M]| {
            for residual in residuals {
                sums.add(residual);
            }
        });
        sums.scatter(0, &self.indices(place.segment), normal);
    }

    /// One segment's residuals with `W` of their derivatives. Not generic over what is done with them, and not inlined: every
    /// simulation is compiled once for each `W`, and that takes long enough.
    #[inline(never)]
    fn single<const W: usize>(
        &self,
        coordinates: &[f64],
        place: Place<M>,
        sink: &mut dyn FnMut(usize, &[Dual<f64, W>; M]),
    ) {
        let range = &self.series.segments()[place.segment];
        let rows = Rows { inputs: self.series.inputs(range.clone()), width: self.series.width() };
        let at = (coordinates, place.first);
        self.stream(at, rows, std::slice::from_ref(range), place.pressures, |k, residuals| {
            sink(k, residuals)
        });
    }

    /// One segment's residuals with all of their derivatives, by as many simulations as it takes.
    fn jacobian(&self, coordinates: &[f64], place: Place<M>) -> Jacobian {
        let directions = self.directions();
        let count = self.series.segments()[place.segment].len() * M;
        let mut jacobian =
            Jacobian { directions, residuals: vec![0.0; count], slopes: vec![0.0; count * directions] };
        if directions <= NARROW {
            self.fill::<NARROW>(coordinates, place, &mut jacobian);
        } else {
            for first in (0..directions).step_by(WIDE) {
                self.fill::<WIDE>(coordinates, Place { first, ..place }, &mut jacobian);
            }
        }
        jacobian
    }

    fn fill<const W: usize>(&self, coordinates: &[f64], place: Place<M>, jacobian: &mut Jacobian) {
        let directions = place.first..jacobian.directions.min(place.first + W);
        self.single(coordinates, place, &mut |k, residuals: &[Dual<f64, W>; M]| {
            for (output, residual) in residuals.iter().enumerate() {
                let at = k * M + output;
                jacobian.residuals[at] = residual.value;
                let row = &mut jacobian.slopes[at * jacobian.directions..][directions.clone()];
                row.copy_from_slice(&residual.gradient[..directions.len()]);
            }
        });
    }
}

/// Which segment is simulated from where, and which direction comes first.
#[derive(Debug, Clone, Copy)]
struct Place<const M: usize> {
    segment: usize,
    pressures: [f64; M],
    first: usize,
}

#[multiversion(targets("x86_64+avx2"))]
fn lockstep_sums<Y: System<N, M>, const W: usize, const N: usize, const M: usize>(
    objective: &RolloutObjective<'_, Y, N, M>,
    coordinates: &[f64],
    segments: &[usize],
    starts: &[[f64; M]],
) -> Accumulator<Lanes<LANES>, W> {
    let series = objective.series;
    let of = |lane: usize| segments[lane.min(segments.len() - 1)];
    let inputs = std::array::from_fn(|lane| series.inputs(series.segments()[of(lane)].clone()));
    let ranges: Vec<Range<usize>> =
        segments.iter().map(|&segment| series.segments()[segment].clone()).collect();
    let pressures = std::array::from_fn(|output| Lanes::from_lanes(|lane| starts[of(lane)][output]));
    let mut sums = Accumulator::new();
    let rows = GatheredRows::new(inputs, series.width());
    objective.stream(
        (coordinates, 0),
        rows,
        &ranges,
        pressures,
        #[inline(always)]
        |_, residuals| {
            for residual in residuals {
                sums.add(residual);
            }
        },
    );
    sums
}

impl<Y: System<N, M>, const N: usize, const M: usize> Objective for RolloutObjective<'_, Y, N, M> {
    fn dimension(&self) -> usize {
        self.free + if self.fitted_starts() { M * self.series.segments().len() } else { 0 }
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        let mut bounds = self.space.bounds();
        bounds.resize(self.dimension(), START_BOUNDS_KPA);
        bounds
    }

    fn nominal(&self) -> Vec<f64> {
        let mut nominal = self.space.nominal();
        if self.fitted_starts() {
            nominal.extend(self.series.starts().iter().flatten().map(|pressure| pressure * KPA_PER_PA));
        }
        nominal
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let parts: Vec<Normal> =
            self.order.par_chunks(LANES).map(|segments| self.group_normal(coordinates, segments)).collect();
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
        for (segment, &pressures) in starts.iter().enumerate() {
            let indices = self.indices(segment);
            let jacobian = self.jacobian(coordinates, Place { segment, pressures, first: 0 });
            let mut score = DVector::zeros(self.dimension());
            let instants =
                jacobian.residuals.chunks_exact(M).zip(jacobian.slopes.chunks_exact(M * indices.len()));
            for (residuals, slopes) in instants {
                score.fill(0.0);
                let mut square = 0.0;
                for (residual, slopes) in residuals.iter().zip(slopes.chunks_exact(indices.len())) {
                    square += residual * residual;
                    for (&index, slope) in indices.iter().zip(slopes) {
                        score[index] += slope * residual;
                    }
                }
                sink(segment, &score, square);
            }
        }
    }
}
