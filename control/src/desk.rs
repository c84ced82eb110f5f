//! A change of parameters as it comes over the bus, until the board's runner takes it.

use crate::{ParameterSet, Stored};
use pneudrive_protocol::pages::{
    Change, ChangeAnswer, CommitOutcome, Entry, Parameter, ParameterSource, StoreState, number_entry,
};

/// What of a board's parameters its pages say and change. Answers must leave within 20 us, so
/// nothing is checked here that takes long.
#[derive(Debug, Clone)]
pub(crate) struct ParameterDesk {
    compiled: ParameterSet,
    in_effect: ParameterSet,
    record: u16,
    source: ParameterSource,
    /// What has been collected since a change was begun, if one was.
    collected: Option<Collected>,
    /// The values of those that have been collected.
    values: ParameterSet,
    outcome: CommitOutcome,
}

/// Copying a whole set would take longer than an answer may.
#[derive(Debug, Clone, Copy)]
struct Collected {
    from_compiled: bool,
    /// Bit n for the parameter with number n.
    set: u32,
}

const _: () = assert!(Parameter::COUNT <= 32);

impl ParameterDesk {
    pub(crate) fn new(set: ParameterSet) -> Self {
        Self {
            compiled: set,
            in_effect: set,
            record: 0,
            source: ParameterSource::Compiled,
            collected: None,
            values: set,
            outcome: CommitOutcome::None,
        }
    }

    pub(crate) fn install(&mut self, compiled: ParameterSet, in_effect: ParameterSet, stored: &Stored) {
        let source = if in_effect == compiled { ParameterSource::Compiled } else { ParameterSource::Stored };
        let record = (stored.number() % 1_024) as u16;
        *self = Self { in_effect, record, source, ..Self::new(compiled) };
    }

    pub(crate) fn in_effect(&self, parameter: Parameter) -> Entry {
        number_entry(self.in_effect.get(parameter))
    }

    pub(crate) fn compiled(&self, parameter: Parameter) -> Entry {
        number_entry(self.compiled.get(parameter))
    }

    pub(crate) fn state(&self) -> StoreState {
        StoreState { outcome: self.outcome, source: self.source, record: self.record }
    }

    /// Obeys a change that came in a session, or not.
    pub(crate) fn change(&mut self, change: Change, in_session: bool) -> ChangeAnswer {
        if !in_session {
            return ChangeAnswer::NeedsSession;
        }
        if self.outcome == CommitOutcome::Pending {
            return ChangeAnswer::Busy;
        }
        match (change, &mut self.collected) {
            (Change::Begin, collected) => *collected = Some(Collected { from_compiled: false, set: 0 }),
            (Change::BeginFromDefaults, collected) => {
                *collected = Some(Collected { from_compiled: true, set: 0 });
            }
            (_, None) => return ChangeAnswer::NotBegun,
            (Change::Set(parameter, value), Some(collected)) => {
                collected.set |= 1 << parameter as u8;
                self.values.set(parameter, value);
            }
            (Change::Commit, Some(_)) => self.outcome = CommitOutcome::Pending,
        }
        ChangeAnswer::Taken
    }

    /// The host has left or fallen silent. A commit that it has made goes on.
    pub(crate) fn forget(&mut self) {
        if self.outcome != CommitOutcome::Pending {
            self.collected = None;
        }
    }

    /// Whether a commit waits to be taken.
    pub(crate) fn is_committed(&self) -> bool {
        self.outcome == CommitOutcome::Pending && self.collected.is_some()
    }

    /// What is to be kept, once after a commit. Without vented chambers, or where nothing changes,
    /// the commit ends here.
    pub(crate) fn take_commit(&mut self, vented: bool) -> Option<ParameterSet> {
        let collected = self.collected.take()?;
        let mut set = if collected.from_compiled { self.compiled } else { self.in_effect };
        for parameter in Parameter::ALL {
            if collected.set >> parameter as u8 & 1 == 1 {
                set.set(parameter, self.values.get(parameter));
            }
        }
        if set == self.in_effect {
            self.outcome = CommitOutcome::Unchanged;
            return None;
        }
        if !vented {
            self.outcome = CommitOutcome::NotVented;
            return None;
        }
        Some(set)
    }

    pub(crate) fn end_commit(&mut self, outcome: CommitOutcome) {
        self.outcome = outcome;
    }
}
