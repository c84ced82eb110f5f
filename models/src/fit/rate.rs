//! Residuals of the model's rate against the measured derivative of the pressure.

use nalgebra::DVector;

use super::derivative::{Slope, slopes};
use super::jacobian::Jacobian;
use super::lockstep::{self, LaneSums};
use super::{Normal, Objective, Space};
use crate::numeric::{Lanes, Real, Scalar};
use crate::rollout::{DIRECTIONS, DualLanes, SENSITIVITY_LANES, Series, System};

/// Samples evaluated at a time.
type Group = Lanes<SENSITIVITY_LANES>;

/// Groups whose residuals are summed up at a time.
const GROUPS: usize = 16;

/// Residuals are in kPa/s.
const KPA_PER_PA: f64 = 1e-3;

/// Sum of the squared differences in kPa/s between a model's rate at the measured pressure and the
/// derivative of the measured pressure ([`slopes`]). Fast, and biased by the noise in the pressure
/// that the model is evaluated at: prefer rollouts.
#[derive(Debug)]
pub struct RateObjective<'a> {
    system: &'a dyn System,
    space: Space,
    slopes: Vec<Slope>,
    width: usize,
    /// Inputs of each group, row by row.
    rows: Vec<Group>,
    /// Where the rates are evaluated, absolute, Pa.
    pressures: Vec<Group>,
    /// What they are compared with, Pa/s.
    measured: Vec<Group>,
    /// The residual's unit; nothing where a lane is spare.
    weights: Vec<Group>,
}

impl<'a> RateObjective<'a> {
    /// The residuals of `series`, differentiated over `half_width` samples to either side, of a
    /// system that has rates.
    #[must_use]
    pub fn new(system: &'a dyn System, series: &'a Series, space: Space, half_width: usize) -> Self {
        let slopes = slopes(series, half_width);
        let groups = || slopes.chunks(SENSITIVITY_LANES);
        let of = |value: &dyn Fn(&Slope) -> f64| -> Vec<Group> {
            groups().map(|part| Lanes::from_lanes(|lane| value(&part[lane.min(part.len() - 1)]))).collect()
        };
        let row = |part: &[Slope], column: usize| {
            Lanes::from_lanes(|lane| series.row(part[lane.min(part.len() - 1)].row)[column])
        };
        let width = series.width();
        Self {
            system,
            space,
            width,
            rows: groups().flat_map(|part| (0..width).map(move |column| row(part, column))).collect(),
            pressures: of(&|slope| slope.pressure_pa),
            measured: of(&|slope| slope.rate_pa_s),
            weights: groups()
                .map(|part| Lanes::from_lanes(|lane| if lane < part.len() { KPA_PER_PA } else { 0.0 }))
                .collect(),
            slopes,
        }
    }

    /// The parameters.
    #[must_use]
    pub fn space(&self) -> &Space {
        &self.space
    }

    /// Weighted residuals with their derivatives in the directions from `first`; `sink` gets the
    /// number of the first group of some.
    fn stream(&self, coordinates: &[f64], first: usize, sink: &mut dyn FnMut(usize, &[DualLanes])) {
        let parameters: Vec<DualLanes> = self.space.duals(coordinates, first);
        let mut block = [DualLanes::constant(0.0); GROUPS];
        for (part, pressures) in self.pressures.chunks(GROUPS).enumerate() {
            let groups = part * GROUPS..part * GROUPS + pressures.len();
            let rows = &self.rows[groups.start * self.width..groups.end * self.width];
            let residuals = &mut block[..pressures.len()];
            self.system.rates(&parameters, rows, pressures, residuals);
            let expected = self.measured[groups.clone()].iter().zip(&self.weights[groups.clone()]);
            for (residual, (measured, weight)) in residuals.iter_mut().zip(expected) {
                *residual = (*residual - DualLanes::from_real(*measured)).scale(*weight);
            }
            sink(groups.start, residuals);
        }
    }

    /// All residuals with all of their derivatives, by as many evaluations as it takes.
    fn jacobian(&self, coordinates: &[f64]) -> Jacobian {
        let (directions, count) = (self.dimension(), self.slopes.len());
        let mut jacobian =
            Jacobian { directions, residuals: vec![0.0; count], slopes: vec![0.0; count * directions] };
        for first in (0..directions).step_by(DIRECTIONS) {
            let some = first..directions.min(first + DIRECTIONS);
            self.stream(coordinates, first, &mut |group, residuals| {
                let at = group * SENSITIVITY_LANES;
                let lanes =
                    residuals.iter().flat_map(|group| (0..SENSITIVITY_LANES).map(move |l| (group, l)));
                for (k, (group, lane)) in (at..count).zip(lanes) {
                    jacobian.residuals[k] = group.value.lane(lane);
                    let row = &mut jacobian.slopes[k * directions..][some.clone()];
                    for (slope, lanes) in row.iter_mut().zip(&group.gradient) {
                        *slope = lanes.lane(lane);
                    }
                }
            });
        }
        jacobian
    }
}

impl Objective for RateObjective<'_> {
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
        if self.dimension() <= DIRECTIONS {
            let mut sums = LaneSums::new();
            self.stream(coordinates, 0, &mut |_, residuals| lockstep::add(&mut sums, residuals));
            sums.scatter_all(&indices, &mut normal);
        } else {
            self.jacobian(coordinates).add_to(&indices, &mut normal);
        }
        normal
    }

    fn residuals(&self) -> usize {
        self.slopes.len()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        let jacobian = self.jacobian(coordinates);
        let mut score = DVector::zeros(self.dimension());
        let rows = jacobian.residuals.iter().zip(jacobian.slopes.chunks_exact(jacobian.directions.max(1)));
        for ((residual, slopes), slope) in rows.zip(&self.slopes) {
            for (score, slope) in score.iter_mut().zip(slopes) {
                *score = slope * residual;
            }
            sink(slope.segment, &score, residual * residual);
        }
    }
}
