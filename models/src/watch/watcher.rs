//! All channels of a rig, row by row.

use super::bin::{Bin, Binning};
use super::block::BLOCK_S;
use super::channel::Channel;
use super::event::{WatchEvent, Where};
use super::explain::explain;
use super::sample::{Columns, Sample};
use super::setup::{WatchError, prepare};
use super::window::StepInputs;
use crate::diagnosis::ExtendedFile;

/// How a rig is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WatchSettings {
    /// Length of the stretch that what is usual is learnt from, s. After a change it is learnt
    /// anew.
    pub learn_s: f64,
}

impl Default for WatchSettings {
    fn default() -> Self {
        Self { learn_s: 600.0 }
    }
}

/// Watches a rig.
#[derive(Clone)]
pub struct Watcher {
    settings: WatchSettings,
    channels: Vec<Channel>,
    binning: Binning,
    columns: Vec<Columns>,
    /// Number of the block that the last step was in.
    block: Option<i64>,
}

impl Watcher {
    /// For recordings with these columns; `name` is the model file's, for messages. Channels that
    /// are not in the model are not watched.
    ///
    /// # Errors
    /// [`WatchError`] when nothing can be watched.
    pub fn new(
        (name, file): (&str, &ExtendedFile),
        columns: Vec<Columns>,
        settings: WatchSettings,
    ) -> Result<Self, WatchError> {
        let mut channels = Vec::new();
        for (place, one) in columns.iter().enumerate() {
            if let Some(stored) = file.channels.get(&one.id.to_string()) {
                let prepared = prepare((name, file), stored, *one)?;
                channels.push(Channel::new(one.id, place, prepared, file.rig.sensor_limits(one.id)));
            }
        }
        if channels.is_empty() {
            let list = |ids: Vec<String>| if ids.is_empty() { "none".to_owned() } else { ids.join(", ") };
            return Err(WatchError::NoChannel {
                file: name.to_owned(),
                recorded: list(columns.iter().map(|c| c.id.to_string()).collect()),
                calibrated: list(file.channels.keys().cloned().collect()),
            });
        }
        let mut in_loop = vec![false; columns.len()];
        for channel in &channels {
            in_loop[channel.place] = channel.prepared.data.inputs.in_loop();
        }
        Ok(Self { settings, channels, binning: Binning::new(in_loop), columns, block: None })
    }

    /// Channels that are watched.
    pub fn watched(&self) -> impl Iterator<Item = crate::data::ChannelId> + '_ {
        self.channels.iter().map(|channel| channel.id)
    }

    /// How far what is furthest from usual stands out now; [`THRESHOLD`](super::THRESHOLD) would be
    /// said.
    #[must_use]
    pub fn statistic(&self) -> f64 {
        self.channels.iter().filter_map(Channel::furthest).map(|found| found.statistic).fold(0.0, f64::max)
    }

    /// Takes the next row; what there is to say goes to `say`.
    pub fn take(&mut self, row: Sample, say: &mut dyn FnMut(WatchEvent)) {
        let Some(bin) = self.binning.take(row) else { return };
        #[allow(clippy::cast_possible_truncation)] // 5 s each
        let block = (bin.t_s / BLOCK_S).floor() as i64;
        if self.block.replace(block).is_some_and(|before| before != block) {
            self.end_block(bin.t_s, say);
        }
        self.step(&bin);
    }

    fn step(&mut self, bin: &Bin) {
        let total: f64 = self.channels.iter().map(|channel| channel.bank.draw).sum();
        for channel in &mut self.channels {
            if bin.fresh {
                channel.bank.stop();
            }
            let others_draw = (total - channel.bank.draw).max(0.0);
            match inputs(channel, &self.columns, bin, others_draw) {
                Some((inputs, measured_pa)) => channel.bank.step(&inputs, measured_pa),
                None => channel.bank.stop(),
            }
        }
    }

    fn end_block(&mut self, t_s: f64, say: &mut dyn FnMut(WatchEvent)) {
        for channel in &mut self.channels {
            if let Some(learnt) = channel.end_block(t_s, self.settings.learn_s) {
                say(WatchEvent::Learnt(learnt));
            }
        }
        for seen in 0..self.channels.len() {
            let Some(alarm) = self.channels[seen].alarm() else { continue };
            let change = explain(&self.channels, seen, &alarm, t_s);
            let on_rig = change.explanations.first().is_some_and(|best| best.place == Where::Rig);
            for (k, channel) in self.channels.iter_mut().enumerate() {
                if on_rig || k == seen {
                    channel.learn_again();
                }
            }
            say(WatchEvent::Changed(change));
        }
    }
}

/// Inputs of a step of a channel, and what was measured at its end (gauge, Pa); none where it
/// cannot be simulated.
fn inputs(
    channel: &Channel,
    columns: &[Columns],
    bin: &Bin,
    others_draw: f64,
) -> Option<(StepInputs, Option<f64>)> {
    let place = channel.place;
    let template = &channel.prepared.data.inputs;
    let ambient_pa = template.ambient_pa;
    let absolute = |kpa: f64| ambient_pa + 1e3 * kpa;
    let usable = |kpa: f64| {
        let within = channel.limits.as_ref().is_none_or(|l| kpa > l.low_kpa && kpa < l.high_kpa);
        (kpa.is_finite() && within).then_some(kpa)
    };
    let mean = bin.inputs[place];
    let needed = if template.in_loop() || channel.prepared.data.plant.model.is_regulator() {
        mean.command_kpa
    } else if columns[place].separate {
        mean.drive + mean.vent
    } else {
        mean.drive
    };
    let start = usable(bin.start[place].pressure_kpa);
    let end = usable(bin.end[place].pressure_kpa);
    if !needed.is_finite() || (bin.fresh && start.is_none()) {
        return None;
    }
    let id = channel.id;
    let of = |number: u8| {
        let found = columns.iter().position(|c| (c.id.board, c.id.channel) == (id.board, number));
        let pa = |place: usize| [bin.start[place].pressure_kpa, bin.end[place].pressure_kpa].map(|p| 1e3 * p);
        found.filter(|found| *found != place).map_or([f64::NAN; 2], pa)
    };
    let last = columns.iter().filter(|c| c.id.board == id.board).map(|c| c.id.channel).max().unwrap_or(0);
    let per_rad = channel.prepared.volume_per_rad_m3;
    let rest_m3 = template.volume_m3[0];
    let [before, after] = [bin.start[place].angle_rad, bin.end[place].angle_rad];
    let moves = per_rad.abs() > 0.0 && mean.angle_rad.is_finite() && (after - before).is_finite();
    let inputs = StepInputs {
        t_s: bin.t_s,
        length_s: bin.length_s,
        drive: [mean.drive, mean.vent],
        command_pa: absolute(if mean.command_kpa.is_finite() { mean.command_kpa } else { 0.0 }),
        supply_pa: if bin.supply_kpa.is_finite() { absolute(bin.supply_kpa) } else { template.supply_pa[0] },
        volume_m3: if moves { (rest_m3 + per_rad * mean.angle_rad).max(0.05 * rest_m3) } else { rest_m3 },
        volume_rate_m3_s: if moves { per_rad * (after - before) / bin.length_s } else { 0.0 },
        measured_pa: [start, end].map(|kpa| absolute(kpa.or(start).or(end).unwrap_or(0.0))),
        opposite_pa: if moves { [f64::NAN; 2] } else { of(id.channel ^ 1) },
        sampled_before_pa: of(if id.channel == 0 { last } else { id.channel - 1 }),
        others_draw,
    };
    Some((inputs, end.map(|kpa| 1e3 * kpa)))
}
