//! Residuals of the model's rate against the measured derivative of the pressure.

use multiversion::multiversion;
use nalgebra::DVector;

use super::derivative::{Slope, slopes};
use super::normal::Accumulator;
use super::{Normal, Objective, Space};
use crate::model::{Drive, Model};
use crate::numeric::{Dual, Lanes, Real, Scalar};
use crate::rollout::Series;

/// Samples evaluated in lockstep.
const LANES: usize = 4;

/// Derivatives computed at a time, for most fits.
const NARROW: usize = 8;

/// The most free parameters of a fit of rates.
pub const MOST_DIRECTIONS: usize = 12;

/// Residuals are in kPa/s.
const KPA_PER_PA: f64 = 1e-3;

/// Sum of the squared differences in kPa/s between a model's rate at the measured pressure and the derivative of the measured
/// pressure ([`slopes`]). Fast, and biased by the noise in the pressure that the model is evaluated at: prefer rollouts.
#[derive(Debug)]
pub struct RateObjective<'a, Q> {
    model: &'a Q,
    series: &'a Series<1>,
    space: Space,
    slopes: Vec<Slope>,
}

impl<'a, Q: Model> RateObjective<'a, Q> {
    /// The residuals of `series`, differentiated over `half_width` samples to either side.
    pub fn new(model: &'a Q, series: &'a Series<1>, space: Space, half_width: usize) -> Self {
        Self { model, series, space, slopes: slopes(series, half_width) }
    }

    /// The parameters.
    #[must_use]
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Residuals of the slopes, weighted; `sink` gets the index of the first of each group of lanes.
    #[inline(always)]
    fn stream<R: Real, const W: usize>(&self, coordinates: &[f64], mut sink: impl FnMut(usize, &Dual<R, W>)) {
        let coefficients = self.model.coefficients(&self.space.duals::<R, W>(coordinates, 0));
        let mut row = vec![R::zero(); self.series.width()];
        for (group, slopes) in self.slopes.chunks(R::LANES).enumerate() {
            let of = |lane: usize| &slopes[lane.min(slopes.len() - 1)];
            for (column, value) in row.iter_mut().enumerate() {
                *value = R::from_lanes(
                    #[inline(always)]
                    |lane| self.series.row(of(lane).row)[column],
                );
            }
            let held = self.model.hold(&coefficients, &row, Drive::recorded(&row));
            let pressure = Dual::from_real(R::from_lanes(
                #[inline(always)]
                |lane| of(lane).pressure_pa,
            ));
            let rate = self.model.rate(&coefficients, &held, pressure);
            let measured = R::from_lanes(
                #[inline(always)]
                |lane| of(lane).rate_pa_s,
            );
            let weight = R::from_lanes(
                #[inline(always)]
                |lane| if lane < slopes.len() { KPA_PER_PA } else { 0.0 },
            );
            sink(group * R::LANES, &(rate - Dual::from_real(measured)).scale(weight));
        }
    }

    fn each_score<const W: usize>(
        &self,
        coordinates: &[f64],
        sink: &mut dyn FnMut(usize, &DVector<f64>, f64),
    ) {
        let mut score = DVector::zeros(self.dimension());
        self.stream::<f64, W>(coordinates, |index, residual| {
            for (score, slope) in score.iter_mut().zip(&residual.gradient) {
                *score = slope * residual.value;
            }
            sink(self.slopes[index].segment, &score, residual.value * residual.value);
        });
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn sums<Q: Model, const W: usize>(
    objective: &RateObjective<'_, Q>,
    coordinates: &[f64],
) -> Accumulator<Lanes<LANES>, W> {
    let mut sums = Accumulator::new();
    objective.stream(
        coordinates,
        #[inline(always)]
        |_, residual| sums.add(residual),
    );
    sums
}

impl<Q: Model> Objective for RateObjective<'_, Q> {
    fn dimension(&self) -> usize {
        self.space.free_count()
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        self.space.bounds()
    }

    fn nominal(&self) -> Vec<f64> {
        self.space.nominal()
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let mut normal = Normal::zeros(self.dimension());
        let indices: Vec<usize> = (0..self.dimension()).collect();
        if self.dimension() <= NARROW {
            sums::<Q, NARROW>(self, coordinates).scatter_all(&indices, &mut normal);
        } else {
            sums::<Q, MOST_DIRECTIONS>(self, coordinates).scatter_all(&indices, &mut normal);
        }
        normal
    }

    fn most_coordinates(&self) -> usize {
        MOST_DIRECTIONS
    }

    fn residuals(&self) -> usize {
        self.slopes.len()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        if self.dimension() <= NARROW {
            self.each_score::<NARROW>(coordinates, sink);
        } else {
            self.each_score::<MOST_DIRECTIONS>(coordinates, sink);
        }
    }
}
