//! What is usual on this rig, learnt from a first stretch: no model is right, and what it lacks
//! shows along some of the directions, more in one movement than in another. That is no change.
//!
//! Of every direction is learnt: how far the rig seems to be along it all the time, by how much
//! that wanders from block to block, and how long it stays where it has wandered. A change has to
//! stand out from all three, and from how well they are known. They are learnt on while the rig is
//! watched: a change is compared with all that was before it (a stretch of eight minutes can be a
//! quiet one by chance).

use nalgebra::{DMatrix, DVector};

use super::block::{Block, at};
use super::usual::{Known, LAGS, Usual};

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

    /// Goes on learning from a block that was weighed.
    pub fn add(&mut self, weighed: &[(f64, f64)]) {
        for (usual, (deviation, weight)) in self.own.iter_mut().zip(weighed) {
            usual.add(*deviation, *weight);
        }
    }

    /// What is known now of each direction.
    pub fn known(&self) -> Vec<Known> {
        self.own.iter().map(Usual::known).collect()
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
    // What the model lacks is no noise: there is less information than white innovations would
    // have.
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
