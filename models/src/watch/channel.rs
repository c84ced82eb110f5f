//! One channel under watch: its observers, what is usual on it, and its history.

use super::bank::Bank;
use super::baseline::Baseline;
use super::block::{BLOCK_S, Block};
use super::event::{Detectable, Learnt};
use super::glr::{Alarm, THRESHOLD, largest};
use super::history::History;
use super::naming::Evidence;
use super::setup::Prepared;
use crate::data::{ChannelId, SensorLimits};

/// Part of the first stretch in which only the innovations' variance and correlation are learnt.
const COLOUR_SHARE: f64 = 0.2;
/// Innovations that these need.
const COLOUR_LEAST: f64 = 200.0;
/// Blocks that what is usual is learnt from at least.
const LEAST_BLOCKS: usize = 24;
/// Innovations without which a block is left out.
const LEAST_COUNT: usize = 20;
/// Changes beyond so many probes are no statement about what can be seen.
const MOST_PROBES: f64 = 20.0;

/// A channel.
#[derive(Clone)]
pub struct Channel {
    /// Which one.
    pub id: ChannelId,
    /// Its observers.
    pub bank: Bank,
    /// Its place among the columns.
    pub place: usize,
    /// As prepared.
    pub prepared: Prepared,
    /// Beyond which its sensor says nothing.
    pub limits: Option<SensorLimits>,
    stage: Stage,
}

#[derive(Clone)]
enum Stage {
    /// So many blocks of the innovations' variance and correlation.
    Colour(usize),
    /// Blocks of what is usual.
    Usual(Vec<Block>),
    /// Changes are looked for.
    Watching(Box<Watching>),
}

/// What a channel has that is watched.
#[derive(Clone)]
pub struct Watching {
    baseline: Baseline,
    history: History,
}

impl Channel {
    /// Before its first step.
    pub fn new(id: ChannelId, place: usize, prepared: Prepared, limits: Option<SensorLimits>) -> Self {
        Self { id, bank: Bank::new(&prepared), place, prepared, limits, stage: Stage::Colour(0) }
    }

    /// Learns anew what is usual.
    pub fn learn_again(&mut self) {
        self.stage = Stage::Usual(Vec::new());
    }

    /// A block has ended at `t_s`. Says when what is usual has been learnt.
    pub fn end_block(&mut self, t_s: f64, learn_s: f64) -> Option<Learnt> {
        let block = self.bank.take_block();
        match &mut self.stage {
            Stage::Colour(blocks) => {
                *blocks += 1;
                if *blocks as f64 * BLOCK_S >= COLOUR_SHARE * learn_s && self.bank.whiten(COLOUR_LEAST) {
                    self.stage = Stage::Usual(Vec::new());
                }
                None
            }
            _ if block.count < LEAST_COUNT => None,
            Stage::Usual(blocks) => {
                blocks.push(block);
                let enough = blocks.len() as f64 * BLOCK_S >= (1.0 - COLOUR_SHARE) * learn_s;
                if !enough || blocks.len() < LEAST_BLOCKS {
                    return None;
                }
                let seconds = blocks.len() as f64 * BLOCK_S;
                let baseline = Baseline::learn(blocks);
                let learnt = self.learnt(t_s, seconds, &baseline);
                let history = History::new(baseline.known(), t_s);
                self.stage = Stage::Watching(Box::new(Watching { baseline, history }));
                Some(learnt)
            }
            Stage::Watching(watching) => {
                let Watching { baseline, history } = watching.as_mut();
                let score = baseline.left(&block);
                let weighed = baseline.weigh(&score, &block);
                baseline.add(&weighed);
                history.add(t_s, (&score, &block.information), &weighed, baseline.known());
                None
            }
        }
    }

    /// The direction that stands out most.
    pub fn furthest(&self) -> Option<Alarm> {
        let Stage::Watching(watching) = &self.stage else { return None };
        largest(&watching.history, &watching.baseline, &self.bank.directions)
    }

    /// The same, if it stands out by enough.
    pub fn alarm(&self) -> Option<Alarm> {
        self.furthest().filter(|found| found.statistic >= THRESHOLD)
    }

    /// The scores since a moment, if the channel was watched then.
    pub fn evidence(&self, since_s: f64) -> Option<Evidence> {
        let Stage::Watching(watching) = &self.stage else { return None };
        let (moment, since) = watching.history.since(since_s)?;
        if since.blocks == 0 { None } else { Evidence::new(&watching.baseline, moment, &since) }
    }

    fn learnt(&self, t_s: f64, seconds: f64, baseline: &Baseline) -> Learnt {
        let known = baseline.known();
        let detectable = self.bank.directions.iter().enumerate().filter_map(|(k, direction)| {
            let probes = known[k].smallest(THRESHOLD);
            let probes = if direction.is_beyond(probes, baseline.usual(k)) { -probes } else { probes };
            let parameter = &direction.info().parameters[0];
            (probes.abs() < MOST_PROBES).then(|| Detectable {
                effect: direction.info().id,
                parameter: parameter.name,
                value: direction.size(probes),
                unit: parameter.unit,
            })
        });
        let whitening = self.bank.whitening();
        Learnt {
            t_s,
            channel: self.id,
            seconds,
            innovation_kpa: whitening.map_or(0.0, |w| 1e-3 * w.deviation_pa),
            detectable: detectable.collect(),
        }
    }
}
