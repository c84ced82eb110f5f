//! A loop that hunts.
//!
//! A loop around a spool with friction or play never rests, and two simulations that differ by next
//! to nothing soon hunt out of step. Nobody recorded the noise that the loop saw between the rows,
//! so no simulation hunts in step with the recording either. How far two of them are apart that
//! differ in this noise alone is what a model may leave without being any worse for it.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;

/// Courses of the noise over which a mean is taken.
const EXPECTED: u64 = 8;

/// Does a board's loop hunt with this effect?
#[must_use]
pub fn is_hunting(effect: usize) -> bool {
    CATALOGUE[effect].makes_limit_cycles()
}

/// Does the loop of this model hunt?
#[must_use]
pub fn hunts(data: &ChannelData, model: &Extended) -> bool {
    data.inputs.in_loop() && model.effects.iter().any(|&e| is_hunting(e))
}

/// The model without what makes a board's loop hunt.
#[must_use]
pub fn at_rest(data: &ChannelData, model: &Extended) -> Extended {
    if !hunts(data, model) {
        return model.clone();
    }
    let hunting = model.effects.iter().copied().filter(|&effect| is_hunting(effect));
    hunting.fold(model.clone(), |model, effect| model.without(&data.plant, effect))
}

/// What a reader of the report should know where a loop hunts.
#[must_use]
pub fn note(channels: &[ChannelData], models: &[Extended]) -> Option<String> {
    channels.iter().zip(models).any(|(data, model)| hunts(data, model)).then(|| {
        format!(
            "The loop hunts around the spool's play or friction, and no simulation hunts in step with it: the error with that cause is the one of the mean of {EXPECTED} simulations, each with a noise of its own, and how far these scatter belongs to what may be left."
        )
    })
}

/// The channel with another course of the noise.
#[must_use]
pub fn otherwise(data: &ChannelData) -> ChannelData {
    let mut other = data.clone();
    if let Some(board) = &mut other.plant.board {
        board.noise_draw += 1;
    }
    other
}

/// Readings as they are expected.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Their mean over some courses of the noise where a loop hunts, and what one rollout says
    /// elsewhere, kPa.
    pub readings: Vec<f64>,
    /// Variance of the hunting about it, kPa^2: of the courses, and of their mean.
    pub hunting: Vec<f64>,
}

impl Expected {
    /// Of a model.
    #[must_use]
    pub fn of(data: &ChannelData, model: &Extended) -> Self {
        let first = data.readings(model);
        if !hunts(data, model) {
            return Self { hunting: vec![0.0; first.len()], readings: first };
        }
        let (mut sum, mut squares) = (vec![0.0; first.len()], vec![0.0; first.len()]);
        let courses = parallel::map(1..EXPECTED, |draw| {
            let mut other = data.clone();
            if let Some(board) = &mut other.plant.board {
                board.noise_draw = draw;
            }
            other.readings(model)
        });
        for readings in &courses {
            for (k, y) in readings.iter().enumerate() {
                sum[k] += y - first[k];
                squares[k] += (y - first[k]).powi(2);
            }
        }
        let count = EXPECTED as f64;
        let variance = |(sum, squares): (&f64, &f64)| {
            (squares - sum * sum / count).max(0.0) / (count - 1.0) * (1.0 + 1.0 / count)
        };
        let hunting = sum.iter().zip(&squares).map(variance).collect();
        Self { readings: first.iter().zip(&sum).map(|(y, sum)| y + sum / count).collect(), hunting }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;
    use crate::effects::catalogue::index_of;

    fn sticking(data: &ChannelData, base: &Extended, threshold: f64) -> Extended {
        base.with(&data.plant, index_of("valve_stiction").unwrap(), &[threshold])
    }

    #[test]
    fn only_a_loop_hunts_and_only_around_friction_or_play() {
        let ((looped, base), (driven, _)) = (channel(true), channel(false));
        let sticks = sticking(&looped, &base, 0.05);
        assert!(hunts(&looped, &sticks) && !hunts(&driven, &sticks) && !hunts(&looped, &base));
        assert_eq!(at_rest(&looped, &sticks), base);
        assert_eq!(at_rest(&driven, &sticks), sticks);
    }

    /// Derivatives along a loop that hunts grow without bound; weights made of them would shrink
    /// everything.
    #[test]
    fn weights_of_a_loop_that_hunts_are_those_of_the_loop_at_rest() {
        let (data, base) = channel(true);
        assert_eq!(data.disturbances(&sticking(&data, &base, 0.05)), data.disturbances(&base));
    }

    #[test]
    fn readings_of_a_loop_that_hunts_are_expected_to_scatter_and_others_are_one_rollout() {
        let (data, base) = channel(true);
        let rollout = data.readings(&base);
        let still = Expected::of(&data, &base);
        assert!(still.readings == rollout && still.hunting.iter().all(|v| *v == 0.0));
        let hunting = Expected::of(&data, &sticking(&data, &base, 0.1));
        let mean = hunting.hunting.iter().sum::<f64>() / rollout.len() as f64;
        assert!(mean > 0.01 && hunting.hunting.iter().all(|v| *v >= 0.0), "{mean}");
        let farther = |readings: &[f64]| -> f64 {
            let other = otherwise(&otherwise(&data)).readings(&sticking(&data, &base, 0.1));
            other.iter().zip(readings).map(|(a, b)| (a - b).powi(2)).sum()
        };
        let one = data.readings(&sticking(&data, &base, 0.1));
        assert!(farther(&hunting.readings) < farther(&one));
    }
}
