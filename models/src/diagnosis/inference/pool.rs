//! One estimate from those of several channels.

use super::Coordinate;
use super::sandwich::BlockError;

/// Reach of an open side among channels of which others close it.
const OPEN_REACH: f64 = 3.0;

/// One estimate from those of several channels. Where they differ by more than their errors allow
/// (each valve has a size of its own), the mean is that of a population with a spread (DerSimonian
/// and Laird, Controlled Clinical Trials 7, 1986), so that a channel with a small error does not
/// speak for the others. What one supply does to all channels in the same block is counted once for
/// all of them.
///
/// Two channels alone say next to nothing about a spread. That sizes differ by `expected`, a
/// standard deviation on the scale of fitting, or less, counts as one channel more (an estimate
/// moderated by a prior: Smyth, Statistical Applications in Genetics and Molecular Biology 3,
/// 2004).
#[must_use]
pub fn pool(channels: &[Coordinate], expected: f64) -> Option<Coordinate> {
    let known: Vec<&Coordinate> = channels.iter().filter(|c| c.error.is_finite()).collect();
    if known.is_empty() {
        return channels.first().cloned();
    }
    let count = known.len() as f64;
    let mean_by = |spread: f64| {
        let weights: Vec<f64> = known.iter().map(|c| 1.0 / (c.error * c.error + spread)).collect();
        let total: f64 = weights.iter().sum();
        let weights: Vec<f64> = weights.iter().map(|w| w / total).collect();
        let value = weights.iter().zip(&known).map(|(w, c)| w * c.value).sum::<f64>();
        (weights, total, value)
    };
    let (weights, total, value) = mean_by(0.0);
    let excess = total * weights.iter().zip(&known).map(|(w, c)| w * (c.value - value).powi(2)).sum::<f64>()
        - (count - 1.0);
    let scale = total * (1.0 - weights.iter().map(|w| w * w).sum::<f64>());
    let seen = if count > 1.0 && scale > 0.0 { (excess / scale).max(0.0) } else { 0.0 };
    let spread = ((count - 1.0) * seen + seen.min(expected * expected)) / count;
    let (weights, _, value) = mean_by(spread);
    let within = within(&known, &weights);
    let between = spread * weights.iter().map(|w| w * w).sum::<f64>();
    // Degrees of freedom of the sum of both variances (Satterthwaite, Biometrics Bulletin 2, 1946):
    // few where the channels' scatter rules, as many as there are channels, one of them expected.
    let own = within.variance / (within.variance + between).max(f64::MIN_POSITIVE);
    let freedom = 1.0 / (own * own / within.freedom + (1.0 - own).powi(2) / count);
    // A side that is open on one channel is closed by the others.
    let reach = [0, 1].map(|side| {
        if known.iter().all(|c| c.reach[side].is_infinite()) {
            return f64::INFINITY;
        }
        weights.iter().zip(&known).map(|(w, c)| w * c.reach[side].min(OPEN_REACH)).sum::<f64>()
    });
    let mean =
        |of: &dyn Fn(&Coordinate) -> f64| weights.iter().zip(&known).map(|(w, c)| w * of(c)).sum::<f64>();
    let as_likely = [0, 1].map(|side| mean(&|c| c.as_likely[side]));
    let halving = mean(&|c| c.halving);
    let considered = mean(&|c| c.considered);
    let error = (within.variance + between).sqrt();
    let by_block = within.by_block;
    Some(Coordinate { value, error, by_block, freedom, reach, as_likely, halving, considered })
}

/// What the channels' own errors leave of a mean. Of channels with the same blocks, by what each
/// block does to all of them; of others, as if nothing were common.
fn within(known: &[&Coordinate], weights: &[f64]) -> BlockError {
    let blocks = known[0].by_block.len();
    if blocks > 0 && known.iter().all(|c| c.by_block.len() == blocks) {
        let of_all = |b: usize| known.iter().zip(weights).map(|(c, w)| w * c.by_block[b]).sum::<f64>();
        let freedom = known.iter().map(|c| c.freedom).fold(f64::INFINITY, f64::min);
        return BlockError::new((0..blocks).map(of_all).collect(), freedom);
    }
    let variance = known.iter().zip(weights).map(|(c, w)| (w * c.error).powi(2)).sum();
    BlockError { variance, freedom: known.iter().map(|c| c.freedom).sum(), by_block: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::super::interval;
    use super::*;
    use crate::model::Scale;

    fn coordinate(value: f64, error: f64, reach: [f64; 2]) -> Coordinate {
        Coordinate {
            value,
            error,
            by_block: Vec::new(),
            freedom: 1e6,
            reach,
            as_likely: [0.0; 2],
            halving: 0.0,
            considered: 0.0,
        }
    }

    #[test]
    fn what_the_integration_step_leaves_is_part_of_the_interval_and_does_not_average_out() {
        let stepped = |halving| Coordinate { halving, ..coordinate(1.0, 0.1, [1.0; 2]) };
        let pooled = pool(&[stepped(0.05), stepped(0.07)], 0.1);
        let Some([low, high]) = pooled.and_then(|p| interval(&p, Scale::Linear)) else {
            panic!("two channels with errors have an interval")
        };
        let half = 0.196 / 2.0_f64.sqrt() + 2.0 * 0.06;
        assert!((low - (1.0 - half)).abs() < 1e-3 && (high - (1.0 + half)).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn channels_are_weighted_by_precision_and_close_each_others_open_sides() {
        let channels = [coordinate(1.0, 0.1, [1.0, 1.0]), coordinate(1.2, 0.3, [1.0, f64::INFINITY])];
        let pooled = pool(&channels, 0.1);
        let Some(p) = pooled else { panic!("two channels with errors have a mean") };
        assert!((p.value - 1.02).abs() < 1e-9, "{p:?}");
        assert!((p.error - 0.3 / 10.0_f64.sqrt()).abs() < 1e-9, "{p:?}");
        assert!((p.reach[0] - 1.0).abs() < 1e-12 && (p.reach[1] - 1.2).abs() < 1e-9, "{p:?}");
    }

    #[test]
    fn sizes_that_are_as_likely_do_not_average_out_either() {
        let hunting = |end| Coordinate { as_likely: [end, 0.0], ..coordinate(1.0, 0.1, [1.0; 2]) };
        let Some([low, high]) =
            pool(&[hunting(0.4), hunting(0.6)], 0.1).and_then(|p| interval(&p, Scale::Linear))
        else {
            panic!("two channels with errors have an interval")
        };
        let half = 0.196 / 2.0_f64.sqrt();
        assert!((low - 0.5).abs() < 1e-9 && (high - (1.0 + half)).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn a_channel_with_a_small_error_does_not_speak_for_channels_that_differ() {
        let mut channels = [1.0, 1.1, 1.2, 1.3].map(|value| coordinate(value, 0.01, [1.0; 2]));
        channels[0].error = 1e-6;
        let Some(p) = pool(&channels, 0.1) else { panic!("channels with errors have a mean") };
        assert!((p.value - 1.15).abs() < 0.01, "{p:?}");
        // By hand: weights 1e12 and three of 1e4, Q = 1400, spread^2 = (1400 - 3) / 6e4 = 0.0233,
        // with the expected one (3 * 0.0233 + 0.01) / 4 = 0.01996, over the root of four channels.
        assert!((p.error - 0.0706).abs() < 0.0005, "{p:?}");
    }

    #[test]
    fn channels_that_disagree_widen_the_interval() {
        let far = [coordinate(1.0, 0.1, [1.0; 2]), coordinate(2.0, 0.1, [1.0; 2])];
        let near = [coordinate(1.0, 0.1, [1.0; 2]), coordinate(1.1, 0.1, [1.0; 2])];
        let error = |channels: &[Coordinate]| pool(channels, 0.0).map_or(0.0, |p| p.error);
        // Half of the square is what two channels show, the other half that nothing was expected.
        let scatter = 0.5 * 0.49 / 2.0 + 0.1_f64.powi(2) / 2.0;
        assert!((error(&far) - scatter.sqrt()).abs() < 1e-9, "{}", error(&far));
        assert!((error(&near) - 0.1 / 2.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn two_channels_that_differ_by_less_than_is_expected_determine_a_size() {
        // Ratios of 0.71 and 0.77, each known to 2 %: not twice as much, and not half as much.
        let two = [coordinate(0.71_f64.ln(), 0.02, [1.0; 2]), coordinate(0.77_f64.ln(), 0.02, [1.0; 2])];
        let ends = pool(&two, 0.1).and_then(|p| interval(&p, Scale::Logarithmic));
        let Some([low, high]) = ends else { panic!("two channels with errors have an interval") };
        assert!((0.6..0.7).contains(&low) && (0.8..0.9).contains(&high), "{low} {high}");
        assert!(pool(&two, 0.1).is_some_and(|p| p.freedom > 2.0), "{:?}", pool(&two, 0.1));
    }

    #[test]
    fn what_a_block_does_to_all_channels_does_not_average_out() {
        let wave: Vec<f64> = (0..20).map(|k| [0.03, -0.04, 0.01, 0.0][k % 4]).collect();
        let moved_by = |by_block: Vec<f64>| {
            let error = BlockError::new(by_block.clone(), 9.0).variance.sqrt();
            Coordinate { by_block, freedom: 5.0, ..coordinate(1.0, error, [1.0; 2]) }
        };
        let one = moved_by(wave);
        let Some(alike) = pool(&[one.clone(), one.clone()], 0.1) else {
            panic!("channels with errors have a mean")
        };
        assert!((alike.error - one.error).abs() < 1e-12 && (alike.freedom - 5.0).abs() < 1e-9, "{alike:?}");
        // What a block does to one channel and takes back on another is nothing to their mean.
        let opposite = moved_by(one.by_block.iter().map(|part| -part).collect());
        let Some(apart) = pool(&[one, opposite], 0.1) else { panic!("channels with errors have a mean") };
        assert!(apart.error < 1e-12, "{apart:?}");
    }
}
