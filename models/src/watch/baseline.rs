//! What is usual on this rig, learnt from a first stretch: no model is right, and what it lacks shows along some of the directions, more in
//! one movement than in another. That is no change.
//!
//! Of every direction is learnt: how far the rig seems to be along it all the time, by how much that wanders from block to block, and how
//! long it stays where it has wandered. A change has to stand out from all three, and from how well so short a stretch tells them.

use nalgebra::{DMatrix, DVector};

use super::block::{Block, at};

/// Deviations of a block beyond so many standard deviations count as so many: no single block is a change.
const OUTLIER: f64 = 4.0;
/// Blocks after which a wander is taken to be over.
const LAGS: usize = 8;
/// Share of the covariances between directions that so few blocks are trusted with.
const TRUSTED: f64 = 0.8;

/// What is usual.
#[derive(Debug, Clone)]
pub struct Baseline {
    /// Size of each effect that the rig seems to have, in probes.
    usual: DVector<f64>,
    /// Of each direction.
    own: Vec<Usual>,
    /// Long-run covariance of blocks' scores.
    covariance: DMatrix<f64>,
}

/// What is usual along one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Usual {
    /// Variance of the score over its information: 1 if innovations were white.
    noise: f64,
    /// Variance of the size from block to block, probes^2.
    wander: f64,
    /// Mean size that is left, probes.
    mean: f64,
    /// Sum of the weights of the blocks that it was learnt from.
    weight: f64,
    /// Blocks that tell as much as one would if each were by itself.
    memory: f64,
    /// Blocks as if each were by itself.
    effective: f64,
    /// Mean information of a block.
    information: f64,
}

impl Baseline {
    /// From the blocks of the first stretch.
    pub fn learn(blocks: &[Block]) -> Self {
        let count = blocks.first().map_or(0, |block| block.score.len());
        let usual = sizes(blocks, count);
        let scores: Vec<DVector<f64>> = blocks.iter().map(|block| left(block, &usual)).collect();
        let of = |k: usize| -> Vec<(f64, f64)> {
            scores.iter().zip(blocks).map(|(score, block)| (score[k], block.own(k))).collect()
        };
        Self { own: (0..count).map(|k| Usual::learn(&of(k))).collect(), covariance: long_run(&scores), usual }
    }

    /// Size along a direction that is usual, probes.
    pub fn usual(&self, k: usize) -> f64 {
        self.usual[k]
    }

    /// The scores of a block without what is usual.
    pub fn left(&self, block: &Block) -> Vec<f64> {
        left(block, &self.usual).as_slice().to_vec()
    }

    /// Deviation and weight of each direction in a block with these scores (without what is usual).
    pub fn weigh(&self, score: &[f64], block: &Block) -> Vec<(f64, f64)> {
        let one = |(k, usual): (usize, &Usual)| usual.weigh(score[k], block.own(k));
        self.own.iter().enumerate().map(one).collect()
    }

    /// How far a direction's sums stand out: twice the logarithm of a likelihood ratio, whose variances are known only as well as they
    /// were learnt.
    pub fn statistic(&self, k: usize, deviation: f64, weight: f64) -> f64 {
        let usual = &self.own[k];
        if weight <= 0.0 || usual.weight <= 0.0 {
            return 0.0;
        }
        let apart = deviation - weight * usual.mean;
        let known = apart * apart / (weight * usual.memory * (1.0 + weight / usual.weight));
        usual.effective * (known / usual.effective).ln_1p()
    }

    /// The size that a direction's sums say, in probes.
    pub fn size(&self, k: usize, deviation: f64, weight: f64) -> f64 {
        if weight > 0.0 { deviation / weight - self.own[k].mean } else { 0.0 }
    }

    /// A sum of scores with this information of its own, without the mean size that is left.
    pub fn centred(&self, k: usize, score: f64, own: f64) -> f64 {
        score - self.own[k].mean * own
    }

    /// Smallest size whose statistic would ever reach a threshold, probes; infinite where nothing tells.
    pub fn smallest(&self, k: usize, threshold: f64) -> f64 {
        let usual = &self.own[k];
        let needed = usual.effective * (threshold / usual.effective).exp_m1();
        (needed * usual.memory / usual.weight).sqrt()
    }

    /// Covariance of the sums of scores over blocks with this information.
    pub fn covariance(&self, information: &[f64]) -> DMatrix<f64> {
        let count = self.own.len();
        let scale: Vec<f64> = (0..count)
            .map(|k| {
                let usual = self.own[k].information;
                if usual > 0.0 { (information[at(k, k)] / usual).max(0.0).sqrt() } else { 0.0 }
            })
            .collect();
        DMatrix::from_fn(count, count, |i, j| {
            let learnt = scale[i] * scale[j] * self.covariance[(i, j)];
            if i == j {
                learnt * (1.0 + 1e-6) + information[at(i, i)] + 1e-9
            } else {
                TRUSTED * learnt + information[at(i, j)]
            }
        })
    }
}

impl Usual {
    fn learn(blocks: &[(f64, f64)]) -> Self {
        let seen: Vec<(f64, f64)> = blocks.iter().copied().filter(|(_, own)| *own > 0.0).collect();
        let count = seen.len() as f64;
        let information = seen.iter().map(|(_, own)| own).sum::<f64>() / blocks.len().max(1) as f64;
        // The squared score over the information is noise + wander * information in the mean: a straight line.
        let (mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0);
        for (score, own) in &seen {
            let square = score * score / own;
            x += own;
            y += square;
            xx += own * own;
            xy += own * square;
        }
        let slope = (count * xy - x * y) / (count * xx - x * x);
        let (mut noise, mut wander) = if slope.is_finite() && slope > 0.0 {
            ((y - slope * x) / count, slope)
        } else {
            (y / count, 0.0)
        };
        if noise < 1.0 {
            (noise, wander) = (1.0, ((y - count) / x).max(0.0));
        }
        let mut usual = Self {
            noise: if noise.is_finite() { noise } else { 1.0 },
            wander: if wander.is_finite() { wander } else { 0.0 },
            mean: 0.0,
            weight: 0.0,
            memory: 1.0,
            effective: 1.0,
            information,
        };
        let weighed: Vec<(f64, f64)> = seen.iter().map(|(score, own)| usual.weigh(*score, *own)).collect();
        usual.weight = weighed.iter().map(|(_, weight)| weight).sum();
        if usual.weight > 0.0 {
            usual.mean = weighed.iter().map(|(deviation, _)| deviation).sum::<f64>() / usual.weight;
        }
        let standard: Vec<f64> =
            weighed.iter().map(|(d, w)| (d - w * usual.mean) / w.max(f64::MIN_POSITIVE).sqrt()).collect();
        usual.memory = memory(&standard);
        usual.effective = (count / usual.memory).max(3.0);
        usual
    }

    fn weigh(&self, score: f64, own: f64) -> (f64, f64) {
        if own <= 0.0 {
            return (0.0, 0.0);
        }
        let weight = own / (self.noise + self.wander * own);
        let standard = (score / (own * (self.noise + self.wander * own)).sqrt()).clamp(-OUTLIER, OUTLIER);
        (weight.sqrt() * standard, weight)
    }
}

/// The sizes that explain all blocks, held to one probe or so each: directions are much alike.
fn sizes(blocks: &[Block], count: usize) -> DVector<f64> {
    let mut information = DMatrix::<f64>::zeros(count, count);
    let mut score = DVector::<f64>::zeros(count);
    let mut excess = Vec::new();
    for block in blocks {
        for i in 0..count {
            score[i] += block.score[i];
            for j in 0..count {
                information[(i, j)] += block.information[at(i, j)];
            }
            if block.own(i) > 0.0 {
                excess.push(block.score[i].powi(2) / block.own(i));
            }
        }
    }
    // What the model lacks is no noise: there is less information than white innovations would have.
    let mean = excess.iter().sum::<f64>() / excess.len().max(1) as f64;
    let inflation = if mean.is_finite() { mean.max(1.0) } else { 1.0 };
    let ridge = DMatrix::<f64>::identity(count, count);
    let solved = (information / inflation + ridge).cholesky().map(|c| c.solve(&(score / inflation)));
    solved.unwrap_or_else(|| DVector::zeros(count))
}

fn left(block: &Block, usual: &DVector<f64>) -> DVector<f64> {
    let count = usual.len();
    DVector::from_fn(count, |i, _| {
        block.score[i] - (0..count).map(|j| block.information[at(i, j)] * usual[j]).sum::<f64>()
    })
}

/// Blocks that tell as much as one by itself would: the sum of the correlations, as seen and as a first-order lag would have them, and the
/// larger for how uncertain they are.
fn memory(standard: &[f64]) -> f64 {
    let count = standard.len();
    let mean = standard.iter().sum::<f64>() / count.max(1) as f64;
    let centred: Vec<f64> = standard.iter().map(|x| x - mean).collect();
    let variance = centred.iter().map(|x| x * x).sum::<f64>();
    if count < 2 * LAGS || variance <= 0.0 {
        return 1.0;
    }
    let correlation =
        |lag: usize| centred.iter().zip(&centred[lag..]).map(|(a, b)| a * b).sum::<f64>() / variance;
    let seen: f64 = (1..=LAGS).map(|l| (1.0 - l as f64 / (LAGS + 1) as f64) * correlation(l).max(0.0)).sum();
    let first = (correlation(1).max(0.0) + (count as f64).sqrt().recip()).min(0.95);
    (1.0 + 2.0 * seen).max((1.0 + first) / (1.0 - first))
}

/// Long-run covariance with Bartlett's weights (Newey and West, Econometrica 55, 1987).
fn long_run(scores: &[DVector<f64>]) -> DMatrix<f64> {
    let Some(first) = scores.first() else { return DMatrix::zeros(0, 0) };
    let mut sum = DMatrix::<f64>::zeros(first.len(), first.len());
    for lag in 0..=LAGS.min(scores.len() - 1) {
        let weight = 1.0 - lag as f64 / (LAGS + 1) as f64;
        for (a, b) in scores.iter().zip(&scores[lag..]) {
            let product = a * b.transpose() * weight;
            sum += &product;
            if lag > 0 {
                sum += product.transpose();
            }
        }
    }
    sum / scores.len() as f64
}
