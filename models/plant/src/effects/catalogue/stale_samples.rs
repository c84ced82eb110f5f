//! `stale_samples`: old samples repeated.

use crate::effects::{Domain, EffectInfo, EffectParameter, ChannelInputs, Hook, Memory, Question, Reach, Step, Trait};
use crate::effects::remembered::Remembered;
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "stale_samples",
    title: "Old samples repeated",
    physics: "Some rows carry the previous measurement again instead of a fresh one.",
    equation: "where a reading repeats the one before exactly though the pressure has moved: y = (1 - share) p + share y_before",
    source: "sample-and-hold of a missed measurement",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("share", "1", (0.0, 0.0, 1.0), "part of the impossible repeats that are stale"),
    ],
    probes: &[&[0.5], &[1.0]],
    rivals: &["sensor_lag", "transport_delay"],
    separated_by: "any movement fast enough that two fresh samples differ",
    smallest: 0.1,
    traits: &[Trait::RoughlyTimed, Trait::Shown(is_shown)],
    check: "measurement task of the board against the bus rate; lost answers that are filled in",
};

/// A coarse converter repeats itself by chance while the pressure moves by less than this many
/// times the noise.
const CHANCE: f64 = 4.0;

/// The effect at work.
#[derive(Debug, Clone)]
pub struct StaleSamples<S> {
    share: S,
    held: Remembered<S>,
}

impl<S: Scalar> StaleSamples<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0], held: Remembered::nothing() }
    }

    /// What is delivered while the old sample is held, or else.
    fn deliver(&mut self, held: bool, noise_pa: f64, fresh: S) -> S {
        let old = self.held.or(fresh);
        if !held {
            self.held.set(fresh);
            return fresh;
        }
        self.held.set(old);
        let back = old - fresh;
        let by_chance = S::constant(CHANCE * noise_pa);
        S::select(by_chance.less(back.abs()), fresh + self.share * back, fresh)
    }
}

/// Does a row repeat the one before it? What was not measured was not repeated either.
fn repeated(inputs: &ChannelInputs, row: usize) -> bool {
    let known = row > 0 && row < inputs.rows() && inputs.usable[row] && inputs.usable[row - 1];
    known && inputs.measured_pa[row].total_cmp(&inputs.measured_pa[row - 1]).is_eq()
}

/// Movements of the pressure, from one row to the next by more than [`CHANCE`] allows, that go on
/// the same way in the next row, and those that go on so only after rows which repeat the reading
/// in between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Movements {
    through: usize,
    stuck: usize,
}

/// Rows for which a reading may stay the same in the midst of a movement: beyond, it is a pause.
const LONGEST: usize = 10;
/// Movements without which nothing is shown: fewer are noise, where rows follow each other so
/// closely that the pressure hardly moves from one to the next.
const LEAST_MOVEMENTS: usize = 100;
/// Part of them that must be stuck: of recordings of the truth plant without this effect at most
/// 1.5 % are, with a fifth of the samples stale 3 % and more.
const LEAST_STUCK: f64 = 0.02;

/// Readings that are `None` are not usable.
fn movements(readings: &[Option<f64>], noise_pa: f64) -> Movements {
    let mut found = Movements { through: 0, stuck: 0 };
    let step = |from: usize, to: usize| Some(readings.get(to).copied()?? - readings[from]?);
    let fast = |change: f64| change.abs() > CHANCE * noise_pa;
    for row in 1..readings.len() {
        let Some(before) = step(row - 1, row).filter(|c| fast(*c)) else { continue };
        let repeats = (row + 1..=row + LONGEST).take_while(|&k| step(row, k) == Some(0.0)).count();
        let after = step(row, row + repeats + 1);
        if after.is_some_and(|after| fast(after) && after * before > 0.0) {
            let count = if repeats > 0 { &mut found.stuck } else { &mut found.through };
            *count += 1;
        }
    }
    found
}

/// A pressure on its way does not stand still for a row and then go on.
fn is_shown(inputs: &ChannelInputs) -> bool {
    let readings = (0..inputs.rows()).map(|row| inputs.usable[row].then_some(inputs.measured_pa[row]));
    let Movements { through, stuck } = movements(&readings.collect::<Vec<_>>(), inputs.noise_pa);
    let all = through + stuck;
    all >= LEAST_MOVEMENTS && stuck as f64 >= LEAST_STUCK * all as f64
}

impl<S: Scalar> Hook<S> for StaleSamples<S> {
    fn reset(&mut self) {
        self.held = Remembered::nothing();
    }

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.held.known().into_iter().for_each(|held| visit(Memory::Known, held));
    }

    /// A board's loop follows the old sample. Rows that are equal say that it was held from some
    /// time before the first of them until some time after the last: half an interval in the mean.
    #[inline(always)]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        let inputs = step.inputs;
        if !inputs.in_loop() {
            return gauge;
        }
        // A loop that ends in the middle is early, however its time is rounded.
        let late = step.end_of_interval() > 0.5 + 1e-6;
        let held = repeated(inputs, step.row + 1) || repeated(inputs, if late { step.row + 2 } else { step.row });
        self.deliver(held, inputs.noise_pa, gauge)
    }

    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        if inputs.in_loop() { reading } else { self.deliver(repeated(inputs, row), inputs.noise_pa, reading) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_movement_is_stuck_where_its_reading_is_repeated_and_then_goes_on_the_same_way() {
        let of = |readings: &[f64]| {
            let readings: Vec<Option<f64>> = readings.iter().map(|v| (*v >= 0.0).then_some(*v)).collect();
            let Movements { through, stuck } = movements(&readings, 1.0);
            (through, stuck)
        };
        assert_eq!(of(&[0.0, 10.0, 20.0, 30.0]), (2, 0));
        assert_eq!(of(&[0.0, 10.0, 10.0, 30.0]), (0, 1));
        assert_eq!(of(&[0.0, 10.0, 10.0, 10.0, 40.0, 50.0]), (1, 1));
        // At rest, back the other way, or as slow as the noise: no movement through anything.
        assert_eq!(of(&[0.0, 10.0, 10.0, 10.0]), (0, 0));
        assert_eq!(of(&[0.0, 10.0, 10.0, 0.0]), (0, 0));
        assert_eq!(of(&[0.0, 3.0, 3.0, 6.0]), (0, 0));
        // A row that is missing repeats nothing, and nobody pauses for so long.
        assert_eq!(of(&[0.0, 10.0, -1.0, 30.0]), (0, 0));
        let pause = [vec![0.0], vec![10.0; LONGEST + 2], vec![20.0]].concat();
        assert_eq!(of(&pause), (0, 0));
    }
}
