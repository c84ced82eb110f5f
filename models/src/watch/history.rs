//! Sums since the moments at which a change may have begun: all recent ones, fewer and fewer of those longer ago.

use super::block::Block;

/// Blocks back to which every one is a candidate; of those further back every fourth, then every sixteenth.
const EVERY: usize = 32;
const FOURTH: usize = 128;
const SIXTEENTH: usize = 1024;

/// Sums up to a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// Blocks.
    pub blocks: usize,
    /// When it was, s.
    pub t_s: f64,
    /// Scores, without what is usual.
    pub score: Vec<f64>,
    /// Information.
    pub information: Vec<f64>,
    /// Weighted deviations and weights, for each direction: see [`Baseline::weigh`](super::baseline::Baseline::weigh).
    pub deviation: Vec<f64>,
    /// See `deviation`.
    pub weight: Vec<f64>,
}

impl Sums {
    fn new(directions: usize, t_s: f64) -> Self {
        let Block { score, information, .. } = Block::new(directions);
        let (deviation, weight) = (score.clone(), score.clone());
        Self { blocks: 0, t_s, score, information, deviation, weight }
    }

    /// What was added since an earlier moment.
    pub fn since(&self, earlier: &Self) -> Self {
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        Self {
            blocks: self.blocks - earlier.blocks,
            t_s: earlier.t_s,
            score: less(&self.score, &earlier.score),
            information: less(&self.information, &earlier.information),
            deviation: less(&self.deviation, &earlier.deviation),
            weight: less(&self.weight, &earlier.weight),
        }
    }
}

/// The moments, the oldest first.
#[derive(Clone)]
pub struct History {
    now: Sums,
    moments: Vec<Sums>,
}

impl History {
    /// Begins.
    pub fn new(directions: usize, t_s: f64) -> Self {
        Self { now: Sums::new(directions, t_s), moments: vec![Sums::new(directions, t_s)] }
    }

    /// Adds a block that ended at `t_s`: its scores without what is usual, its information, deviations and weights.
    pub fn add(&mut self, t_s: f64, score: &[f64], information: &[f64], weighed: &[(f64, f64)]) {
        let add = |sums: &mut [f64], values: &[f64]| sums.iter_mut().zip(values).for_each(|(s, v)| *s += v);
        add(&mut self.now.score, score);
        add(&mut self.now.information, information);
        for (k, (deviation, weight)) in weighed.iter().enumerate() {
            self.now.deviation[k] += deviation;
            self.now.weight[k] += weight;
        }
        self.now.blocks += 1;
        self.now.t_s = t_s;
        self.moments.push(self.now.clone());
        let now = self.now.blocks;
        self.moments.retain(|moment| {
            let every = match now - moment.blocks {
                ..EVERY => 1,
                EVERY..FOURTH => 4,
                FOURTH..SIXTEENTH => 16,
                _ => return false,
            };
            moment.blocks.is_multiple_of(every)
        });
    }

    /// What was added since each moment but the last `least` blocks.
    pub fn windows(&self, least: usize) -> impl Iterator<Item = (&Sums, usize)> {
        let now = self.now.blocks;
        self.moments.iter().map(move |moment| (moment, now - moment.blocks)).filter(move |(_, n)| *n >= least)
    }

    /// Everything so far.
    pub fn now(&self) -> &Sums {
        &self.now
    }

    /// What was added since the moment nearest to `t_s`.
    pub fn since(&self, t_s: f64) -> Sums {
        let far = |moment: &&Sums| (moment.t_s - t_s).abs();
        let nearest = self.moments.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        self.now.since(nearest.unwrap_or(&self.now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_does_not_grow_and_sums_are_right() {
        let mut history = History::new(1, 0.0);
        for k in 1..=5000 {
            history.add(5.0 * f64::from(k), &[f64::from(k)], &[1.0], &[(2.0, 0.5)]);
        }
        assert!(history.moments.len() < 120, "{}", history.moments.len());
        let since = history.since(5.0 * 4990.0);
        assert_eq!((since.blocks, since.t_s), (10, 24_950.0));
        assert_eq!(since.score[0], (4991..=5000).map(f64::from).sum::<f64>());
        assert_eq!((since.deviation[0], since.weight[0]), (20.0, 5.0));
        let oldest = history.windows(3).map(|(_, n)| n).max();
        assert!(oldest.is_some_and(|n| (1000..1024).contains(&n)), "{oldest:?}");
    }
}
