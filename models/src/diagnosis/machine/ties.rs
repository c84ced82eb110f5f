//! Which parameters are alike in all recordings of a machine, and which are each recording's own.

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::estimation::free_base;
use crate::effects::catalogue::CATALOGUE;

/// The models of one channel in all recordings: the same effects, and what is the machine's has the
/// same values.
#[derive(Debug, Clone, PartialEq)]
pub struct TiedModel {
    /// One model a recording.
    pub models: Vec<Extended>,
}

impl TiedModel {
    /// The same model for all recordings.
    #[must_use]
    pub fn alike(model: Extended, recordings: usize) -> Self {
        Self { models: vec![model; recordings] }
    }

    /// The same with something done to each recording's model.
    #[must_use]
    pub fn each(&self, change: impl Fn(&Extended) -> Extended) -> Self {
        Self { models: self.models.iter().map(change).collect() }
    }
}

/// How much of a model is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom<'a> {
    /// What is the machine's is alike, and fitted with the loads.
    Machine,
    /// All parameters of effects are each recording's own, whoever's they are: from bad starts this
    /// gets stuck less often.
    Loose,
    /// The machine is known, with these effects: of them only what is the load's is fitted, of
    /// others everything.
    Known(&'a [usize]),
    /// The loads are alike, too.
    OneLoad,
}

/// Positions of parameters in the models of one channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ties {
    /// Those that are alike in all recordings.
    pub machine: Vec<usize>,
    /// Those that are each recording's own.
    pub load: Vec<usize>,
    /// The load's scale, which stays as it is in the first recording: of a machine that is not
    /// known, only ratios can be told.
    pub anchored: Option<usize>,
}

impl Ties {
    /// Those of a model with some freedom.
    #[must_use]
    pub fn of(data: &ChannelData, model: &Extended, freedom: Freedom<'_>) -> Self {
        let base = data.plant.parameters().len();
        let mut ties = Self { machine: free_base(data), load: Vec::new(), anchored: None };
        let mut position = base;
        for &effect in &model.effects {
            let info = CATALOGUE[effect];
            for p in info.parameters {
                let own = match freedom {
                    Freedom::Machine => p.of_load,
                    Freedom::Known(known) => p.of_load || !known.contains(&effect),
                    Freedom::Loose => true,
                    Freedom::OneLoad => false,
                };
                if own { &mut ties.load } else { &mut ties.machine }.push(position);
                if info.is_scale_of_load() && !matches!(freedom, Freedom::Known(_)) {
                    ties.anchored = Some(position);
                }
                position += 1;
            }
        }
        match freedom {
            // The machine's curves are known, and with them what its load is measured by.
            Freedom::Known(_) => ties.machine.clear(),
            Freedom::OneLoad => ties.machine.retain(|k| Some(*k) != ties.anchored),
            Freedom::Machine | Freedom::Loose => {}
        }
        ties
    }

    /// All free positions, the machine's first.
    #[must_use]
    pub fn free(&self) -> Vec<usize> {
        self.machine.iter().chain(&self.load).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, with};

    fn names(data: &ChannelData, model: &Extended, positions: &[usize]) -> Vec<String> {
        let parameters = model.parameters(&data.plant);
        positions.iter().map(|&k| parameters[k].name.clone()).collect()
    }

    #[test]
    fn valves_are_the_machines_and_what_is_behind_them_the_loads() {
        let (data, base) = channel(false);
        let model = with(&data, &base, "valve_lag", &[0.02]);
        let model = with(&data, &model, "line_restriction", &[0.3, 0.05, 1.0]);
        let model = with(&data, &model, "chamber_volume", &[1.0]);
        let ties = Ties::of(&data, &model, Freedom::Machine);
        let load = names(&data, &model, &ties.load);
        assert_eq!(
            load,
            ["line_restriction.time_constant", "line_restriction.laminar", "chamber_volume.ratio"]
        );
        let machine = names(&data, &model, &ties.machine);
        assert!(machine.contains(&"valve_lag.time_constant".to_owned()), "{machine:?}");
        assert!(machine.contains(&"line_restriction.volume_ratio".to_owned()), "{machine:?}");
        assert_eq!(names(&data, &model, ties.anchored.as_slice()), ["chamber_volume.ratio"]);
        // A known machine has a scale, and nothing of it is fitted.
        let known = Ties::of(&data, &model, Freedom::Known(&model.effects));
        assert_eq!((known.machine.len(), known.load, known.anchored), (0, ties.load, None));
        // An effect that the machine was not known to have is looked for as a whole.
        let lag = Ties::of(&data, &model, Freedom::Known(&model.effects[1..]));
        assert!(names(&data, &model, &lag.load).contains(&"valve_lag.time_constant".to_owned()));
        let one = Ties::of(&data, &model, Freedom::OneLoad);
        assert!(one.load.is_empty() && !one.machine.contains(&ties.anchored.expect("it has a scale")));
    }
}
