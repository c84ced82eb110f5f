//! What has changed? The scores of all directions since the change, under every effect in turn.
//!
//! Under an effect the scores are its column of the information times its size, and what is usual
//! beside; how the scores of healthy blocks vary together was learnt. No effect fits to the last:
//! what the best leaves beyond that scales all distances (Birge's ratio), so that names are as
//! uncertain as the best of them fits badly. Directions are straight lines for a small probe, and a
//! large change has left them: effects that explain it to within a hundredth of its squared
//! distance are told together, however much longer it lasts.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::baseline::Baseline;
use super::block::at;
use super::history::{Moment, Sums};

/// Prior scale of a size, probes. Sizes far beyond it are unlikely, as Cauchy's distribution has
/// it: without that a slower vent was named an offset of 98 kPa, which no sensor has.
const PRIOR_PROBES: f64 = 3.0;
/// Share of the squared distance from what is usual that straight directions are trusted with.
/// Without it a valve of 0.85 times the flow was named a larger chamber, with certainty.
const STRAIGHT: f64 = 0.01;
/// Share of the distance from what is usual that a name must not leave: something else leaves as
/// much.
const LEFT: f64 = 0.3;

/// A channel's scores since the change.
pub struct Evidence {
    score: DVector<f64>,
    /// Size along each direction that was usual before, probes.
    usual: DVector<f64>,
    information: DMatrix<f64>,
    cholesky: Cholesky<f64, Dyn>,
    /// Squared distance of the scores from what is usual.
    distance: f64,
    /// What squared distances are divided by: what the best effect leaves beyond what is usual, or
    /// the share of the distance by which directions are not straight; at least 1.
    scale: f64,
}

/// What one effect says of the scores.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Log-likelihood, its size integrated out, over that of nothing having changed.
    pub gain: f64,
    /// Size, probes.
    pub size: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Evidence {
    /// Of the blocks since the change, at this moment; none where they cannot be compared.
    pub fn new(baseline: &Baseline, change: &Moment, since: &Sums) -> Option<Self> {
        let count = since.score.len();
        let centred = |k: usize, _| change.known[k].centred(since.score[k], since.information[at(k, k)]);
        let score = DVector::from_fn(count, centred);
        let cholesky = baseline.covariance(&since.information).cholesky()?;
        let distance = score.dot(&cholesky.solve(&score));
        let information = DMatrix::from_fn(count, count, |i, j| since.information[at(i, j)]);
        let usual = DVector::from_fn(count, |k, _| baseline.usual(k));
        let mut evidence = Self { score, usual, information, cholesky, distance, scale: 1.0 };
        let most = (0..count).map(|k| evidence.explained(k).0).fold(0.0, f64::max);
        evidence.scale = ((distance - most) / count as f64).max(STRAIGHT * distance).max(1.0);
        Some(evidence)
    }

    /// Under the effect along direction `k`.
    pub fn of(&self, k: usize) -> Fitted {
        let (explained, size, precision) = self.explained(k);
        let precision = precision / self.scale;
        let prior = (PRIOR_PROBES * PRIOR_PROBES * precision).max(1.0).ln();
        Fitted {
            gain: 0.5 * (explained / self.scale - prior),
            size,
            standard_error: precision.recip().sqrt(),
        }
    }

    /// Size along a direction that was usual before, probes.
    pub fn usual(&self, k: usize) -> f64 {
        self.usual[k]
    }

    /// The same of something that is not in the catalogue.
    pub fn something_else(&self) -> f64 {
        0.5 * (1.0 - LEFT) * self.distance / self.scale
    }

    /// Squared distance that a direction takes, its size, and the size's precision.
    fn explained(&self, k: usize) -> (f64, f64, f64) {
        let along: DVector<f64> = self.information.column(k).into_owned();
        let weighted = self.cholesky.solve(&along);
        let precision = along.dot(&weighted) + PRIOR_PROBES.powi(-2);
        let projected = self.score.dot(&weighted);
        (projected * projected / precision, projected / precision, precision)
    }
}

impl Fitted {
    /// Log-odds of this effect: its gain, less for how unlikely so large a size is.
    pub fn odds(&self) -> f64 {
        self.gain - (self.size / PRIOR_PROBES).powi(2).ln_1p()
    }
}

/// One size for several channels: of their sizes by precision, and what the likelihoods of each
/// lose by it.
pub fn common(fitted: &[Fitted]) -> Fitted {
    let precision: f64 = fitted.iter().map(|f| f.standard_error.powi(-2)).sum();
    let size = fitted.iter().map(|f| f.size * f.standard_error.powi(-2)).sum::<f64>() / precision;
    let apart: f64 = fitted.iter().map(|f| ((f.size - size) / f.standard_error).powi(2)).sum();
    // Each likelihood has paid for a size of its own; one is enough.
    let paid = |standard_error: f64| (PRIOR_PROBES / standard_error).max(1.0).ln();
    let standard_error = precision.recip().sqrt();
    let back = fitted.iter().map(|f| paid(f.standard_error)).sum::<f64>() - paid(standard_error);
    Fitted { gain: fitted.iter().map(|f| f.gain).sum::<f64>() - 0.5 * apart + back, size, standard_error }
}
