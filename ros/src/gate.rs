//! Which commands get through to the boards.

use crate::channel_names::ChannelNames;
use crate::pressure::{Command, Part};
use crate::refusal::{Counters, Refusal};
use pneudrive_host::poller::{BoardCommand, Limits, SetPoints, VENTED};
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use pneudrive_record::messages::Time;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Where a joint's commands go, and how high they may be.
#[derive(Debug, Clone)]
pub struct Joint {
    /// What it and its channels are called.
    pub names: ChannelNames,
    /// Its board's number on the bus.
    pub board: u8,
    /// The board's place in the poller's order.
    pub index: usize,
    /// Highest set points.
    pub limits: Limits,
    /// What its channels' counts mean.
    pub scales: [SensorScale; CHANNELS],
}

/// Stands between the command topic of one joint and its board.
#[derive(Debug)]
pub struct CommandGate {
    set_points: SetPoints,
    joint: Joint,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    counters: Counters,
    /// When each channel's last command was accepted, ns since 1970; `None` while it is vented for
    /// want of one.
    commanded_ns: [Option<u64>; CHANNELS],
}

impl CommandGate {
    /// Commands of `joint` into `set_points`.
    pub fn new(set_points: SetPoints, joint: Joint) -> Self {
        Self { set_points, joint, state: Mutex::default() }
    }

    /// Follows a command that came at `now_ns` since 1970. A stamp of 0 counts as none. No age is
    /// too high if `max_age_ns` is 0.
    ///
    /// # Errors
    /// Why it was not followed; that is counted.
    pub fn offer(&self, command: &Command<'_>, now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
        let checked = fresh(command.stamp, now_ns, max_age_ns).and_then(|()| self.read(command));
        let mut state = self.lock();
        match checked {
            Ok(changes) => {
                state.counters.accepted += 1;
                for (at_ns, _) in state.commanded_ns.iter_mut().zip(changes).filter(|(_, new)| new.is_some())
                {
                    *at_ns = Some(now_ns);
                }
                self.change(changes);
                Ok(())
            }
            Err(refusal) => {
                *state.counters.refused_for(&refusal) += 1;
                Err(refusal)
            }
        }
    }

    /// Vents the channels whose last command is older than `timeout_ns`; returns whether there were
    /// any. Never if that is 0.
    pub fn expire(&self, now_ns: u64, timeout_ns: u64) -> bool {
        let mut state = self.lock();
        let mut changes = [None; CHANNELS];
        for (commanded_ns, change) in state.commanded_ns.iter_mut().zip(&mut changes) {
            let age_ns = commanded_ns.map(|at_ns| now_ns.saturating_sub(at_ns));
            if timeout_ns > 0 && age_ns.is_some_and(|age_ns| age_ns > timeout_ns) {
                *commanded_ns = None;
                *change = Some(Counts::ATMOSPHERE);
            }
        }
        let expired = changes.iter().any(Option::is_some);
        if expired {
            state.counters.timeouts += 1;
            self.change(changes);
        }
        expired
    }

    /// Forgets what was commanded: 0 kPa until the next command.
    pub fn clear(&self) {
        let mut state = self.lock();
        state.commanded_ns = [None; CHANNELS];
        self.change([Some(Counts::ATMOSPHERE); CHANNELS]);
    }

    /// What its joint and its channels are called.
    pub fn names(&self) -> &ChannelNames {
        &self.joint.names
    }

    /// What has come so far.
    pub fn counters(&self) -> Counters {
        self.lock().counters
    }

    /// What a command changes: all four channels, or those that it names.
    fn read(&self, command: &Command<'_>) -> Result<[Option<Counts>; CHANNELS], Refusal> {
        if command.kpa.is_empty() && command.has_numbers_elsewhere {
            return Err(Refusal::NotInEffort);
        }
        let mut changes = [None; CHANNELS];
        if let Part::Chamber(channel) = command.part {
            for &kpa in command.kpa.iter() {
                changes[channel] = Some(self.counts(channel, kpa)?);
            }
            return Ok(changes);
        }
        if command.names.is_empty() {
            if command.kpa.len() != CHANNELS {
                return Err(Refusal::WrongLength { found: command.kpa.len() });
            }
            for (channel, (change, &kpa)) in changes.iter_mut().zip(command.kpa.iter()).enumerate() {
                *change = Some(self.counts(channel, kpa)?);
            }
            return Ok(changes);
        }
        if command.names.len() != command.kpa.len() {
            return Err(Refusal::NamesAndValues { names: command.names.len(), values: command.kpa.len() });
        }
        for (name, &kpa) in command.names.iter().zip(command.kpa.iter()) {
            let names = &self.joint.names;
            let Some(channel) = names.channel(name) else {
                let (joint, known) = (names.joint(), names.known());
                return Err(Refusal::UnknownName { name: name.clone(), joint, known });
            };
            if changes[channel].replace(self.counts(channel, kpa)?).is_some() {
                return Err(Refusal::NamedTwice { name: name.clone() });
            }
        }
        Ok(changes)
    }

    fn counts(&self, channel: usize, kpa: f64) -> Result<Counts, Refusal> {
        if !kpa.is_finite() {
            return Err(Refusal::NotFinite { channel, kpa });
        }
        let Joint { board, limits, scales, .. } = &self.joint;
        let out_of_range = |reason: String| Refusal::OutOfRange { channel, reason };
        let counts = scales[channel].counts(kpa).map_err(|error| out_of_range(error.to_string()))?;
        limits.check(*board, channel, kpa).map_err(|error| out_of_range(error.to_string()))?;
        Ok(counts)
    }

    fn change(&self, changes: [Option<Counts>; CHANNELS]) {
        let index = self.joint.index;
        let mut command: BoardCommand = self.set_points.get(index).unwrap_or(VENTED);
        for (counts, change) in command.iter_mut().zip(changes) {
            *counts = change.unwrap_or(*counts);
        }
        if let Err(error) = self.set_points.set(index, command) {
            log::error!("{error}");
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn fresh(stamp: Time, now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
    if max_age_ns == 0 || stamp.is_zero() || now_ns.abs_diff(stamp.unix_ns()) <= max_age_ns {
        return Ok(());
    }
    let age_s = (i128::from(now_ns) - i128::from(stamp.unix_ns())) as f64 * 1e-9;
    Err(Refusal::Stale { age_s, limit_s: max_age_ns as f64 * 1e-9 })
}

#[cfg(test)]
mod tests;
