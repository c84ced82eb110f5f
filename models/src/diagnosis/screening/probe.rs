//! Probes: every effect simulated at a few sizes, and what each takes out of the residual.

use std::borrow::Cow;

use super::cycles::{Cycles, Search};
use super::scores::scores;
use super::thinning::thinned;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, readings_of};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::{at_rest, hunts, is_hunting};
use crate::effects::catalogue::CATALOGUE;
use crate::model::Scale;

/// A direction that takes no more than this part out of the squared residual is not followed
/// further.
const HOPELESS: f64 = 0.002;

/// One size of one effect, tried on one channel.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Number of the probe.
    pub probe: usize,
    /// The model with the effect at this size and its other parameters compensating: where a fit
    /// starts.
    pub start: Extended,
    /// Scores, in the order of the blocks; zero where a block does not count.
    pub scores: Vec<f64>,
    /// What the effect changes in the whitened readings beyond what the other parameters make up
    /// for, [thinned].
    pub direction: Vec<f32>,
    /// Sum of squared whitened residuals of `start` on the open blocks.
    pub loss: f64,
    /// The same at the best size along the direction, at which an effect smaller or larger than the
    /// probe is not worse off.
    pub promise: f64,
    /// Does only one sign of the score speak for the effect?
    pub one_sided: bool,
    /// Of a probe that was searched for in the recording: how far that stands out of what chance
    /// finds.
    pub searched: Option<Search>,
}

/// A channel on which effects are tried.
pub struct Probing<'a> {
    data: &'a ChannelData,
    stage: &'a ChannelStage,
    /// The same channel in coarser steps of the board's loop, where it is part of the simulation:
    /// what an effect changes is the difference of two simulations, from which most of what the
    /// steps leave drops out.
    rough: Cow<'a, ChannelData>,
    /// Readings of the stage's model in those steps, kPa.
    readings: Cow<'a, [f64]>,
    /// The same without what makes the loop hunt, where it does: two simulations that hunt differ
    /// by being out of step.
    at_rest: Option<Vec<f64>>,
}

impl<'a> Probing<'a> {
    /// Prepares a channel.
    pub fn new(data: &'a ChannelData, stage: &'a ChannelStage) -> Self {
        let rough = data.rough();
        let same = matches!(rough, Cow::Borrowed(_));
        let readings =
            if same { Cow::Borrowed(&stage.readings[..]) } else { Cow::Owned(rough.readings(&stage.model)) };
        let at_rest = hunts(data, &stage.model).then(|| rough.readings(&at_rest(data, &stage.model)));
        Self { data, stage, rough, readings, at_rest }
    }

    /// Tries all sizes of an effect; those that come back are tried at `cycles`, which were
    /// searched for.
    pub fn try_effect(&self, effect: usize, cycles: &Cycles) -> Vec<Trial> {
        let info = CATALOGUE[effect];
        let (probes, searched): (Vec<Vec<f64>>, _) = if info.probes.is_empty() {
            (cycles.waves.iter().flat_map(|wave| info.probes_of(wave)).collect(), Some(cycles.search))
        } else {
            (info.probes.iter().map(|p| p.to_vec()).collect(), None)
        };
        let first = info.parameters[0];
        let one_sided = first.null <= first.lower || first.null >= first.upper;
        self.try_probes(effect, &probes)
            .into_iter()
            .enumerate()
            .filter_map(|(probe, tried)| tried.map(|tried| (probe, tried)))
            .map(|(probe, Tried { start, direction, loss, promise })| Trial {
                effect,
                probe,
                start,
                scores: scores(self.data, &self.stage.residuals, &direction, &OPEN),
                direction: thinned(self.data, &direction),
                loss,
                promise,
                one_sided,
                searched,
            })
            .collect()
    }

    /// The model with an effect at some sizes; `None` where its simulation runs away.
    fn try_probes(&self, effect: usize, probes: &[Vec<f64>]) -> Vec<Option<Tried>> {
        let (data, stage) = (self.data, self.stage);
        let mut models: Vec<Extended> =
            probes.iter().map(|values| stage.model.with(&data.plant, effect, values)).collect();
        // The model's own parameters give way, first to keep the readings where they were.
        let mut tried: Vec<Option<Tried>> = self
            .changes(effect, &models)
            .into_iter()
            .zip(&mut models)
            .map(|(mut linear, model)| {
                let along = stage.project(data, &linear);
                let back: Vec<f64> = along.iter().map(|c| -c).collect();
                self.give_way(model, effect, &back);
                stage.remove(&mut linear, &along);
                let [own, dot, square] = products(data, &stage.residuals, &linear);
                let next_to_nothing = !(dot * dot > HOPELESS * own * square);
                (next_to_nothing && linear.iter().all(|v| v.is_finite())).then(|| Tried {
                    start: model.clone(),
                    direction: linear,
                    loss: own - 2.0 * dot + square,
                    promise: own,
                })
            })
            .collect();
        // Where something of it is in the residual, what the parameters do exactly is worth a
        // simulation.
        let open: Vec<usize> = (0..probes.len()).filter(|&k| tried[k].is_none()).collect();
        let models: Vec<Extended> = open.iter().map(|&k| models[k].clone()).collect();
        let changes = self.changes(effect, &models);
        for ((k, model), change) in open.into_iter().zip(models).zip(changes) {
            tried[k] = self.closest(effect, model, change);
        }
        tried
    }

    /// What another channel's readings are beyond this one's with the same model, whitened, in
    /// standard deviations of the noise.
    pub fn change_of(&self, other: &ChannelData) -> Vec<f64> {
        let (data, stage) = (self.data, self.stage);
        let before = self.at_rest.as_deref().unwrap_or(&self.readings);
        let mut change = other.rough().readings(&at_rest(data, &stage.model));
        change.iter_mut().zip(before).for_each(|(y, y0)| *y = (*y - y0) / data.noise_kpa);
        stage.whitening.apply(&mut change);
        change
    }

    /// What an effect changes in the whitened readings, in standard deviations of the noise.
    pub fn changes(&self, effect: usize, models: &[Extended]) -> Vec<Vec<f64>> {
        let (data, stage) = (self.data, self.stage);
        let (mut changes, before) = match &self.at_rest {
            Some(readings) if !is_hunting(effect) => {
                let models: Vec<Extended> = models.iter().map(|model| at_rest(data, model)).collect();
                (readings_of(&self.rough, &models), &readings[..])
            }
            _ => (readings_of(&self.rough, models), &*self.readings),
        };
        for change in &mut changes {
            change.iter_mut().zip(before).for_each(|(y, y0)| *y = (*y - y0) / data.noise_kpa);
            stage.whitening.apply(change);
        }
        changes
    }

    /// Moves the parameters that the stage's model has of its own.
    fn give_way(&self, model: &mut Extended, effect: usize, coefficients: &[f64]) {
        let (data, stage) = (self.data, self.stage);
        let parameters = stage.model.parameters(&data.plant);
        for (&k, c) in stage.free.iter().zip(coefficients) {
            let p = &parameters[k];
            let Some(position) = stage.moved(data, k, effect) else { continue };
            let value = &mut model.values[position];
            *value = match p.scale {
                Scale::Linear => *value + c,
                Scale::Logarithmic => *value * c.clamp(-2.0, 2.0).exp(),
            }
            .clamp(p.lower, p.upper);
        }
    }

    /// Where the parameters come as close to the measurement as they can beside the effect, from
    /// where they made up for it and left this change of the readings.
    fn closest(&self, effect: usize, mut start: Extended, mut direction: Vec<f64>) -> Option<Tried> {
        if !direction.iter().all(|v| v.is_finite()) {
            return None;
        }
        let (data, stage) = (self.data, self.stage);
        let mut closest: Vec<f64> = stage.residuals.iter().zip(&direction).map(|(r, d)| r - d).collect();
        let forward = stage.project(data, &closest);
        let rest = stage.project(data, &direction);
        stage.remove(&mut direction, &rest);
        stage.remove(&mut closest, &forward);
        let open = data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role));
        let loss = open.map(|(_, span)| closest[span.clone()].iter().map(|v| v * v).sum::<f64>()).sum();
        self.give_way(&mut start, effect, &forward);
        let [own, dot, square] = products(data, &stage.residuals, &direction);
        let scaled = if dot > 0.0 { own - dot * dot / square } else { own };
        Some(Tried { start, direction, loss, promise: loss.min(scaled) })
    }
}

/// One size of an effect.
struct Tried {
    /// See [`Trial::start`].
    start: Extended,
    /// What it changes in the whitened readings beyond what the parameters make up for.
    direction: Vec<f64>,
    /// See [`Trial::loss`].
    loss: f64,
    /// See [`Trial::promise`].
    promise: f64,
}

/// Products on the open blocks: residual by itself, by a direction, and the direction by itself.
fn products(data: &ChannelData, residuals: &[f64], direction: &[f64]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (_, span) in data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role)) {
        for (r, d) in residuals[span.clone()].iter().zip(&direction[span.clone()]) {
            sums = [sums[0] + r * r, sums[1] + r * d, sums[2] + d * d];
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, fitted, measured, with};
    use crate::effects::catalogue::index_of;

    #[test]
    fn the_probe_of_the_size_that_is_there_takes_most_of_the_error() {
        let (data, base) = channel(false);
        let data = measured(data.clone(), &with(&data, &base, "valve_lag", &[0.03]), 1);
        let stage = ChannelStage::new(&data, base.clone(), (0..base.values.len()).collect());
        let lag = index_of("valve_lag").unwrap();
        let trials = Probing::new(&data, &stage).try_effect(lag, &Cycles::default());
        let sizes = CATALOGUE[lag].probes;
        assert_eq!(trials.len(), sizes.len());
        let best = trials.iter().min_by(|a, b| a.loss.total_cmp(&b.loss)).unwrap();
        assert_eq!(sizes[best.probe], [0.03]);
        let [own, ..] = products(&data, &stage.residuals, &stage.residuals);
        let rows = data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role));
        let rows: usize = rows.map(|(_, span)| span.len()).sum();
        // It takes most of what the noise does not explain.
        assert!(own - best.loss > 0.8 * (own - rows as f64), "{own}, then {} in {rows} rows", best.loss);
        for trial in &trials {
            // A lag is there or not; no trial promises less than it leaves.
            assert!(trial.one_sided && trial.promise <= trial.loss, "{trial:?}");
            assert_eq!(trial.start.effects, [lag]);
        }
        // Where it is, the score speaks for it.
        assert!(best.scores.iter().sum::<f64>() > 0.0);
    }

    #[test]
    fn what_the_base_parameters_can_do_as_well_is_no_direction_of_an_effect() {
        // A valve that opens more is another gain: nothing is left of it.
        let (data, base) = channel(false);
        let data = measured(data.clone(), &with(&data, &base, "valve_gain", &[1.2]), 2);
        let stage = fitted(&data, &base);
        for trial in
            Probing::new(&data, &stage).try_effect(index_of("valve_gain").unwrap(), &Cycles::default())
        {
            let score: f64 = trial.scores.iter().sum();
            assert!(score.abs() < 0.01 * products(&data, &stage.residuals, &stage.residuals)[0], "{score}");
        }
    }
}
