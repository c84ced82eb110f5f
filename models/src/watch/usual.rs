//! What is usual along one direction: learnt from a first stretch, and from every block that comes
//! after it.

/// Deviations of a block beyond so many standard deviations count as so many: no single block is a
/// change.
const OUTLIER: f64 = 4.0;
/// Blocks after which a wander is taken to be over.
pub const LAGS: usize = 16;
/// What is known of any rig beforehand, and for how many blocks that counts: long-run variances of
/// a few minutes that happen to be quiet are too small, of one rig by four times. Two hours of
/// eight virtual rigs (`watch_table`, seeds 62081 to 62130 and 64022, which the published rate was
/// not measured on) told 3 to 5 blocks of most directions, and 0.8 to 2.6 times the first stretch's
/// squares.
const PRIOR_BLOCKS: f64 = 50.0;
const PRIOR_MEMORY: f64 = 4.0;
const PRIOR_SQUARE: f64 = 1.3;
/// Blocks as if each were by itself that anything is taken to be learnt from.
const LEAST_EFFECTIVE: f64 = 3.0;

/// How a block is weighed, and what is known of all blocks so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Usual {
    /// Variance of the score over its information: 1 if innovations were white.
    noise: f64,
    /// Variance of the size from block to block, probes^2.
    wander: f64,
    /// Mean information of a block of the first stretch.
    pub information: f64,
    /// Mean size, probes.
    mean: f64,
    /// Sum of the blocks' weights.
    weight: f64,
    /// Blocks that told something.
    count: f64,
    /// Sum of the squares of their deviations from the mean, in standard deviations.
    squares: f64,
    /// Sums of the products of each with those before it, the next one first.
    products: [f64; LAGS],
    /// The last ones, the newest first.
    recent: [f64; LAGS],
}

/// What was known up to a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Known {
    /// Mean size, probes.
    mean: f64,
    /// Sum of the blocks' weights.
    weight: f64,
    /// Long-run variance of blocks' deviations, in those that their weights say: 1 if each were by
    /// itself and as noisy as the first.
    spread: f64,
    /// Blocks as if each were by itself.
    effective: f64,
}

impl Usual {
    /// From the score and the information of each block of a first stretch.
    pub fn learn(blocks: &[(f64, f64)]) -> Self {
        let seen: Vec<(f64, f64)> = blocks.iter().copied().filter(|(_, own)| *own > 0.0).collect();
        let information = seen.iter().map(|(_, own)| own).sum::<f64>() / blocks.len().max(1) as f64;
        let (noise, wander) = line(&seen);
        let mut usual = Self {
            noise: if noise.is_finite() { noise } else { 1.0 },
            wander: if wander.is_finite() { wander } else { 0.0 },
            information,
            mean: 0.0,
            weight: 0.0,
            count: 0.0,
            squares: 0.0,
            products: [0.0; LAGS],
            recent: [0.0; LAGS],
        };
        let weighed: Vec<(f64, f64)> = seen.iter().map(|(score, own)| usual.weigh(*score, *own)).collect();
        let sum = |of: fn(&(f64, f64)) -> f64| weighed.iter().map(of).sum::<f64>();
        usual.weight = sum(|(_, weight)| *weight);
        if usual.weight > 0.0 {
            usual.mean = sum(|(deviation, _)| *deviation) / usual.weight;
        }
        for (deviation, weight) in weighed {
            usual.count((deviation - weight * usual.mean) / weight.max(f64::MIN_POSITIVE).sqrt());
        }
        usual
    }

    /// Deviation and weight of a block with this score (without what is usual) and information.
    pub fn weigh(&self, score: f64, own: f64) -> (f64, f64) {
        if own <= 0.0 {
            return (0.0, 0.0);
        }
        let weight = own / (self.noise + self.wander * own);
        let standard = (score / (own * (self.noise + self.wander * own)).sqrt()).clamp(-OUTLIER, OUTLIER);
        (weight.sqrt() * standard, weight)
    }

    /// Goes on learning: a block of this deviation and weight.
    pub fn add(&mut self, deviation: f64, weight: f64) {
        if weight <= 0.0 {
            return;
        }
        // From the mean as it was before: what a block makes of the mean does not hide it.
        self.count((deviation - weight * self.mean) / weight.sqrt());
        self.weight += weight;
        self.mean += (deviation - weight * self.mean) / self.weight;
    }

    fn count(&mut self, standard: f64) {
        self.count += 1.0;
        self.squares += standard * standard;
        for (product, before) in self.products.iter_mut().zip(self.recent) {
            *product += standard * before;
        }
        self.recent.rotate_right(1);
        self.recent[0] = standard;
    }

    /// What is known now.
    pub fn known(&self) -> Known {
        let with_prior = |sum: f64, prior: f64| (sum + PRIOR_BLOCKS * prior) / (self.count + PRIOR_BLOCKS);
        let memory = with_prior(self.count * self.memory(), PRIOR_MEMORY);
        Known {
            mean: self.mean,
            weight: self.weight,
            spread: memory * with_prior(self.squares, PRIOR_SQUARE),
            effective: (self.count / memory).max(LEAST_EFFECTIVE),
        }
    }

    /// Blocks that tell as much as one by itself would: the sum of the correlations, as seen and as
    /// a first-order lag would have them, and the larger for how uncertain they are.
    fn memory(&self) -> f64 {
        if self.count < (2 * LAGS) as f64 || self.squares <= 0.0 {
            return 1.0;
        }
        let correlation = |lag: usize| (self.products[lag - 1] / self.squares).max(0.0);
        let seen: f64 = (1..=LAGS).map(|lag| (1.0 - lag as f64 / (LAGS + 1) as f64) * correlation(lag)).sum();
        let first = (correlation(1) + self.count.sqrt().recip()).min(0.95);
        (1.0 + 2.0 * seen).max((1.0 + first) / (1.0 - first))
    }
}

impl Known {
    /// How far sums of deviations and weights since the moment stand out: twice the logarithm of a
    /// likelihood ratio, whose variances are known only as well as so many blocks tell them.
    pub fn statistic(&self, deviation: f64, weight: f64) -> f64 {
        if weight <= 0.0 || self.weight <= 0.0 {
            return 0.0;
        }
        let apart = deviation - weight * self.mean;
        let known = apart * apart / (weight * self.spread * (1.0 + weight / self.weight));
        self.effective * (known / self.effective).ln_1p()
    }

    /// The size that such sums say, in probes.
    pub fn size(&self, deviation: f64, weight: f64) -> f64 {
        if weight > 0.0 { deviation / weight - self.mean } else { 0.0 }
    }

    /// A sum of scores with this information of its own, without the mean size.
    pub fn centred(&self, score: f64, own: f64) -> f64 {
        score - self.mean * own
    }

    /// Smallest size whose statistic would ever reach a threshold, probes; infinite where nothing
    /// tells.
    pub fn smallest(&self, threshold: f64) -> f64 {
        let needed = self.effective * (threshold / self.effective).exp_m1();
        (needed * self.spread / self.weight).sqrt()
    }
}

/// The squared score over the information is noise + wander * information in the mean: a straight
/// line.
fn line(seen: &[(f64, f64)]) -> (f64, f64) {
    let count = seen.len() as f64;
    let (mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0);
    for (score, own) in seen {
        let square = score * score / own;
        x += own;
        y += square;
        xx += own * own;
        xy += own * square;
    }
    let slope = (count * xy - x * y) / (count * xx - x * x);
    let (noise, wander) =
        if slope.is_finite() && slope > 0.0 { ((y - slope * x) / count, slope) } else { (y / count, 0.0) };
    if noise < 1.0 { (1.0, ((y - count) / x).max(0.0)) } else { (noise, wander) }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Scores of blocks with the information 1, whose neighbours are correlated by `memory`.
    fn scores(count: usize, size: f64, memory: f64, seed: u64) -> Vec<f64> {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut at = 0.0;
        let mut next = || {
            let noise: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
            at = memory * at + (1.0 - memory * memory).sqrt() * noise;
            size * at
        };
        (0..count).map(|_| next()).collect()
    }

    fn learnt(scores: &[f64]) -> Usual {
        Usual::learn(&scores.iter().map(|score| (*score, 1.0)).collect::<Vec<_>>())
    }

    /// The largest statistic of the last twelve of these scores.
    fn stands_out(usual: &Usual, scores: &[f64]) -> f64 {
        let sums = |scores: &[f64]| {
            let weighed = scores.iter().map(|score| usual.weigh(*score, 1.0));
            weighed.fold((0.0, 0.0), |(d, w), (deviation, weight)| (d + deviation, w + weight))
        };
        let (deviation, weight) = sums(scores);
        usual.known().statistic(deviation, weight)
    }

    #[test]
    fn a_rig_that_came_to_wander_more_is_believed_less() {
        let quiet = scores(96, 1.0, 0.2, 1);
        let wild = scores(800, 2.0, 0.7, 2);
        let mut usual = learnt(&quiet);
        let excursion = [4.0; 12];
        let at_first = stands_out(&usual, &excursion);
        for score in wild {
            let (deviation, weight) = usual.weigh(score, 1.0);
            usual.add(deviation, weight);
        }
        let afterwards = stands_out(&usual, &excursion);
        assert!(at_first > 30.0 && afterwards < 0.5 * at_first, "{at_first} {afterwards}");
    }

    #[test]
    fn a_steady_rig_is_known_better_the_longer_it_is_seen() {
        let mut usual = learnt(&scores(96, 1.0, 0.3, 3));
        let at_first = usual.known().smallest(50.0);
        for score in scores(900, 1.0, 0.3, 4) {
            let (deviation, weight) = usual.weigh(score, 1.0);
            usual.add(deviation, weight);
        }
        let afterwards = usual.known().smallest(50.0);
        assert!(afterwards < 0.4 * at_first, "{at_first} {afterwards}");
    }

    #[test]
    fn learning_on_is_as_learning_at_once() {
        let all = scores(1000, 1.5, 0.5, 5);
        let (first, rest) = all.split_at(500);
        let mut usual = learnt(first);
        for score in rest {
            let (deviation, weight) = usual.weigh(*score, 1.0);
            usual.add(deviation, weight);
        }
        let (stepwise, at_once) = (usual.known(), learnt(&all).known());
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.1;
        // In probes and as they were weighed: what a weight is was learnt from the first part
        // alone.
        let spread = |known: Known| known.spread / known.weight;
        assert!(near(spread(stepwise), spread(at_once)), "{stepwise:?} {at_once:?}");
        assert!(near(stepwise.effective, at_once.effective), "{stepwise:?} {at_once:?}");
    }
}
