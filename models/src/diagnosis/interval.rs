//! How well the recording determines an effect's parameters.
//!
//! Standard errors come from the block sandwich `H^-1 (sum s_b s_b^T) H^-1` of the scores `s_b` of whole blocks (valid however the
//! residual is correlated within a block); on a logarithmic scale the interval is symmetric in the logarithm.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::blocks::Role;
use super::channel::ChannelData;
use super::stage::{ChannelStage, OPEN};
use crate::model::Scale;

/// An estimate on the scale on which the parameter is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Value, or its logarithm.
    pub value: f64,
    /// Standard error; infinite where the data say nothing.
    pub error: f64,
    /// Degrees of freedom of the error.
    pub freedom: f64,
}

/// Covariance of a channel's free parameters.
#[must_use]
pub fn covariance(data: &ChannelData, stage: &ChannelStage) -> Option<DMatrix<f64>> {
    let n = stage.free.len();
    let mut bread = DMatrix::<f64>::zeros(n, n);
    let mut meat = DMatrix::<f64>::zeros(n, n);
    for (block, span) in data.blocks.iter().zip(&data.spans) {
        if !OPEN.contains(&block.role) {
            continue;
        }
        let mut score = DVector::<f64>::zeros(n);
        for row in span.clone() {
            let s = &stage.sensitivities[row * n..(row + 1) * n];
            for a in 0..n {
                if block.role == Role::Fit {
                    for b in 0..n {
                        bread[(a, b)] += s[a] * s[b];
                    }
                }
                score[a] += s[a] * stage.residuals[row];
            }
        }
        if block.role == Role::Fit {
            meat += &score * score.transpose();
        }
    }
    // A parameter on its bound or without influence has no slope: leave it out by giving it its own.
    for k in 0..n {
        if bread[(k, k)] <= 0.0 {
            bread[(k, k)] = 1e-30;
        }
    }
    let scale = DVector::from_fn(n, |k, _| bread[(k, k)].sqrt().recip());
    let scaled = DMatrix::from_fn(n, n, |a, b| bread[(a, b)] * scale[a] * scale[b]);
    let inverse = (scaled + DMatrix::identity(n, n) * 1e-10).try_inverse()?;
    let inverse = DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] * scale[a] * scale[b]);
    let blocks = data.blocks.iter().filter(|b| b.role == Role::Fit).count() as f64;
    let correction = blocks / (blocks - 1.0).max(1.0);
    Some(&inverse * meat * &inverse * correction)
}

/// The parameters of one effect on one channel.
#[must_use]
pub fn coordinates(data: &ChannelData, stage: &ChannelStage, effect: usize) -> Vec<Coordinate> {
    let Some(range) = stage.model.range(&data.plant, effect) else {
        return Vec::new();
    };
    let parameters = stage.model.parameters(&data.plant);
    let covariance = covariance(data, stage);
    let freedom = (data.blocks.iter().filter(|b| b.role == Role::Fit).count() as f64 - 1.0).max(1.0);
    range
        .map(|position| {
            let p = &parameters[position];
            let raw = stage.model.values[position];
            let value = match p.scale {
                Scale::Linear => raw,
                Scale::Logarithmic => raw.ln(),
            };
            let at = stage.free.iter().position(|&k| k == position);
            let error = match (&covariance, at) {
                (Some(c), Some(k)) if c[(k, k)].is_finite() && c[(k, k)] > 0.0 => c[(k, k)].sqrt(),
                _ => f64::INFINITY,
            };
            Coordinate { value, error, freedom }
        })
        .collect()
}

/// One estimate from those of several channels: weighted by precision, the error widened where they disagree more than theirs
/// allow.
#[must_use]
pub fn pool(channels: &[Coordinate]) -> Option<Coordinate> {
    let known: Vec<&Coordinate> = channels.iter().filter(|c| c.error.is_finite()).collect();
    if known.is_empty() {
        return channels.first().copied();
    }
    let weight = |c: &Coordinate| 1.0 / (c.error * c.error);
    let total: f64 = known.iter().map(|c| weight(c)).sum();
    let value = known.iter().map(|c| weight(c) * c.value).sum::<f64>() / total;
    let count = known.len() as f64;
    let spread = known.iter().map(|c| weight(c) * (c.value - value).powi(2)).sum::<f64>();
    let widening = if count > 1.0 { (spread / (count - 1.0)).max(1.0) } else { 1.0 };
    let freedom = known.iter().map(|c| c.freedom).sum::<f64>();
    Some(Coordinate { value, error: (widening / total).sqrt(), freedom })
}

/// The 95 % interval in the parameter's own unit.
#[must_use]
pub fn interval(coordinate: &Coordinate, scale: Scale) -> Option<[f64; 2]> {
    if !coordinate.error.is_finite() {
        return None;
    }
    let t = StudentsT::new(0.0, 1.0, coordinate.freedom).map_or(2.0, |d| d.inverse_cdf(0.975));
    let ends = [coordinate.value - t * coordinate.error, coordinate.value + t * coordinate.error];
    Some(match scale {
        Scale::Linear => ends,
        Scale::Logarithmic => ends.map(f64::exp),
    })
}
