//! All pairs of effects, screened as pairs.
//!
//! Two effects may take little each and much together, and what takes most alone need be neither.
//! What each changes in the readings is known from its probes; to first order, what two of them
//! leave of the residual follows from products of these.

use super::probe::Trial;
use super::thinning::{stride, thinned};
use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::estimation::ChannelStage;
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;
use crate::order::descending;
use crate::parallel;

/// Two directions with less between them than this part of their squares are one.
const PARALLEL: f64 = 1e-3;

/// Two effects of the catalogue, and what they promise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The one that promises more alone, and the other.
    pub effects: [usize; 2],
    /// What both promise to take together of the squared whitened residuals.
    pub gain: f64,
}

/// Pairs of causes by what they promise over all channels, most first. What stands for causes
/// outside the catalogue is in none.
#[must_use]
pub fn promising_pairs(channels: &[ChannelData], stages: &[ChannelStage], tried: &[Vec<Trial>]) -> Vec<Pair> {
    let by_channel = parallel::map(channels.iter().zip(stages).zip(tried), |((data, stage), tried)| {
        gains(data, stage, tried)
    });
    let total = |a: usize, b: usize| by_channel.iter().map(|gains| gains[a][b]).sum::<f64>();
    let named = |&effect: &usize| CATALOGUE[effect].question != Question::Foil;
    let effects: Vec<usize> = (0..CATALOGUE.len()).filter(named).collect();
    let mut pairs = Vec::new();
    for (k, &a) in effects.iter().enumerate() {
        for &b in &effects[..k] {
            let (alone, gain) = ([total(a, a), total(b, b)], total(a, b));
            // What promises nothing alone may do so beside another: of an effect that has one
            // direction only, the other hides which.
            if alone[0].min(alone[1]) > 0.0 || gain > alone[0].max(alone[1]) {
                let effects = if alone[0] > alone[1] { [a, b] } else { [b, a] };
                pairs.push(Pair { effects, gain });
            }
        }
    }
    descending(&mut pairs, |pair| pair.gain);
    pairs
}

/// What every two effects promise to take on one channel with the best of their sizes, and each
/// alone on the diagonal.
fn gains(data: &ChannelData, stage: &ChannelStage, tried: &[Trial]) -> Vec<Vec<f64>> {
    let residuals = thinned(data, &stage.residuals);
    let each = stride(data) as f64; // a row that is looked at stands for so many
    let product = |a: &[f32], b: &[f32]| each * a.iter().zip(b).map(|(a, b)| f64::from(a * b)).sum::<f64>();
    let along: Vec<f64> = tried.iter().map(|trial| product(&residuals, &trial.direction)).collect();
    let squares: Vec<f64> = tried.iter().map(|trial| product(&trial.direction, &trial.direction)).collect();
    let allowed = |k: usize, size: f64| size > 0.0 || !tried[k].one_sided;
    let mut best = vec![vec![0.0_f64; CATALOGUE.len()]; CATALOGUE.len()];
    for (i, one) in tried.iter().enumerate() {
        if squares[i] > 0.0 && allowed(i, along[i]) {
            let alone = &mut best[one.effect][one.effect];
            *alone = alone.max(along[i] * along[i] / squares[i]);
        }
        for (j, other) in tried[..i].iter().enumerate().filter(|(_, other)| other.effect != one.effect) {
            let cross = product(&one.direction, &other.direction);
            let determinant = squares[i] * squares[j] - cross * cross;
            if determinant > PARALLEL * squares[i] * squares[j] {
                let of_one = (along[i] * squares[j] - along[j] * cross) / determinant;
                let of_other = (along[j] * squares[i] - along[i] * cross) / determinant;
                if allowed(i, of_one) && allowed(j, of_other) {
                    let both = &mut best[one.effect][other.effect];
                    *both = both.max(of_one * along[i] + of_other * along[j]);
                }
            }
        }
    }
    // A pair takes at least what one of it does, in whatever order they were tried.
    let together = |a: usize, b: usize| best[a][b].max(best[b][a]).max(best[a][a]).max(best[b][b]);
    (0..best.len()).map(|a| (0..best.len()).map(|b| together(a, b)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::screening::trials;
    use crate::diagnosis::testing::{STRUCTURE, channel, fitted, measured, with};
    use crate::effects::catalogue::index_of;

    #[test]
    fn the_two_that_are_there_are_the_most_promising_of_all_pairs() {
        let (data, base) = channel(false);
        let stretched = with(&data, &base, "wall_compliance", &[0.1]);
        let truth = with(&data, &stretched, "valve_lag", &[0.03]);
        let channels = [measured(data, &truth, 1)];
        let stages = [fitted(&channels[0], &base)];
        let tried = trials(&channels, &stages, STRUCTURE, &|| {});
        let pairs = promising_pairs(&channels, &stages, &tried);
        let id = |effect: usize| CATALOGUE[effect].id;
        let first = pairs[0].effects.map(id);
        assert_eq!(first, ["valve_lag", "wall_compliance"], "the first of them takes more alone");
        let singles = gains(&channels[0], &stages[0], &tried[0]);
        let alone = |id: &str| singles[index_of(id).unwrap()][index_of(id).unwrap()];
        assert!(pairs[0].gain > alone("valve_lag") && alone("valve_lag") > alone("wall_compliance"));
        // None of them stands for what is not in the catalogue, and none comes twice.
        let effects = pairs.iter().flat_map(|pair| pair.effects);
        assert!(effects.clone().all(|effect| CATALOGUE[effect].question == Question::Structure));
        let mut sets: Vec<[usize; 2]> = pairs.iter().map(|pair| pair.effects).collect();
        sets.iter_mut().for_each(|set| set.sort_unstable());
        sets.sort_unstable();
        sets.dedup();
        assert_eq!(sets.len(), pairs.len());
    }

    /// A muffler can only slow what vents. Where what else is wrong makes vents look slow already,
    /// it would have to make them faster, until the other is there.
    #[test]
    fn what_goes_the_wrong_way_alone_is_in_a_pair_with_what_turns_it_round() {
        let (data, base) = channel(false);
        let mut stage = fitted(&data, &base);
        let [lag, muffler, wear] =
            ["sensor_lag", "vent_restriction", "valve_wear"].map(|id| index_of(id).unwrap());
        let waves = |mix: [f64; 3]| -> Vec<f64> {
            let wave = |row: usize, k: usize| (0.1 * (k + 1) as f64 * row as f64).sin();
            (0..data.rows.len()).map(|row| (0..3).map(|k| mix[k] * wave(row, k)).sum()).collect()
        };
        // The muffler does much of the opposite of the lag, and something of its own; wear has no
        // part.
        stage.residuals = waves([1.0, 0.3, -0.2]);
        let trial = |effect: usize, mix: [f64; 3]| Trial {
            effect,
            probe: 0,
            start: base.clone(),
            scores: Vec::new(),
            direction: thinned(&data, &waves(mix)),
            loss: 0.0,
            promise: 0.0,
            one_sided: true,
            searched: None,
        };
        let tried = [vec![
            trial(lag, [1.0, 0.0, 0.0]),
            trial(muffler, [-0.8, 0.6, 0.0]),
            trial(wear, [-0.8, 0.0, 0.6]),
        ]];
        let pairs = promising_pairs(std::slice::from_ref(&data), &[stage], &tried);
        assert_eq!(pairs.iter().map(|pair| pair.effects).collect::<Vec<_>>(), [[lag, muffler]]);
    }
}
