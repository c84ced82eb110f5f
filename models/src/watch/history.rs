//! Sums since the moments at which a change may have begun: all recent ones, fewer and fewer of
//! those longer ago.

use super::block::Block;
use super::usual::Known;

/// Blocks back to which every one is a candidate; of those further back every fourth, then every
/// sixteenth.
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
    /// Weighted deviations and weights, for each direction: see
    /// [`Usual::weigh`](super::usual::Usual::weigh).
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

/// A moment at which a change may have begun.
#[derive(Clone)]
pub struct Moment {
    /// Sums up to it.
    pub sums: Sums,
    /// What was known of each direction.
    pub known: Vec<Known>,
}

/// The moments, the oldest first.
#[derive(Clone)]
pub struct History {
    now: Sums,
    moments: Vec<Moment>,
}

impl History {
    /// Begins, with this known of each direction.
    pub fn new(known: Vec<Known>, t_s: f64) -> Self {
        let now = Sums::new(known.len(), t_s);
        Self { moments: vec![Moment { sums: now.clone(), known }], now }
    }

    /// Adds a block that ended at `t_s`: its scores without what is usual, its information,
    /// deviations and weights; and what is known with it.
    pub fn add(
        &mut self,
        t_s: f64,
        (score, information): (&[f64], &[f64]),
        weighed: &[(f64, f64)],
        known: Vec<Known>,
    ) {
        let add = |sums: &mut [f64], values: &[f64]| sums.iter_mut().zip(values).for_each(|(s, v)| *s += v);
        add(&mut self.now.score, score);
        add(&mut self.now.information, information);
        for (k, (deviation, weight)) in weighed.iter().enumerate() {
            self.now.deviation[k] += deviation;
            self.now.weight[k] += weight;
        }
        self.now.blocks += 1;
        self.now.t_s = t_s;
        self.moments.push(Moment { sums: self.now.clone(), known });
        let now = self.now.blocks;
        self.moments.retain(|Moment { sums, .. }| {
            let every = match now - sums.blocks {
                ..EVERY => 1,
                EVERY..FOURTH => 4,
                FOURTH..SIXTEENTH => 16,
                _ => return false,
            };
            sums.blocks.is_multiple_of(every)
        });
    }

    /// The moments but those of the last `least` blocks.
    pub fn moments(&self, least: usize) -> impl Iterator<Item = &Moment> {
        let now = self.now.blocks;
        self.moments.iter().filter(move |moment| now - moment.sums.blocks >= least)
    }

    /// Everything so far.
    pub fn now(&self) -> &Sums {
        &self.now
    }

    /// The moment nearest to `t_s`, and what was added since.
    pub fn since(&self, t_s: f64) -> Option<(&Moment, Sums)> {
        let far = |moment: &&Moment| (moment.sums.t_s - t_s).abs();
        let nearest = self.moments.iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
        Some((nearest, self.now.since(&nearest.sums)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::usual::Usual;
    use super::*;

    #[test]
    fn it_does_not_grow_and_sums_are_right() {
        let known = || vec![Usual::learn(&[]).known()];
        let mut history = History::new(known(), 0.0);
        for k in 1..=5000 {
            history.add(5.0 * f64::from(k), (&[f64::from(k)], &[1.0]), &[(2.0, 0.5)], known());
        }
        assert!(history.moments.len() < 120, "{}", history.moments.len());
        let (moment, since) = history.since(5.0 * 4990.0).expect("a moment");
        assert_eq!(moment.sums.blocks, 4990);
        assert_eq!((since.blocks, since.t_s), (10, 24_950.0));
        assert_eq!(since.score[0], (4991..=5000).map(f64::from).sum::<f64>());
        assert_eq!((since.deviation[0], since.weight[0]), (20.0, 5.0));
        let oldest = history.moments(3).map(|moment| 5000 - moment.sums.blocks).max();
        assert!(oldest.is_some_and(|n| (1000..1024).contains(&n)), "{oldest:?}");
    }
}
