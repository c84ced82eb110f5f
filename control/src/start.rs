//! What a board starts with, and what it does about a commit.

use crate::store::{Flash, WriteFailed};
use crate::{BoardConfig, BusPort, ParameterSet, Stored};
use pneudrive_protocol::Address;
use pneudrive_protocol::pages::CommitOutcome;

/// A board's configuration at its start: as compiled, with what flash keeps over it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardStart {
    compiled: BoardConfig,
    stored: Stored,
    in_effect: ParameterSet,
    config: BoardConfig,
    address: Address,
}

impl BoardStart {
    /// With what `flash` keeps, for a board whose switch stands at `switch`. Values that do not go
    /// together with those of this firmware are left alone, all of them: then it starts as
    /// compiled.
    pub fn load(flash: &impl Flash, compiled: BoardConfig, switch: Address) -> Self {
        let stored = Stored::load(flash);
        let as_compiled = ParameterSet::of(&compiled);
        let wanted = stored.over(&as_compiled);
        let (in_effect, config) = match wanted.apply_to(&compiled) {
            Ok(config) => (wanted, config),
            Err(_) => (as_compiled, compiled),
        };
        Self { compiled, stored, in_effect, config, address: in_effect.address(switch) }
    }

    /// The configuration in effect.
    pub fn config(&self) -> &BoardConfig {
        &self.config
    }

    /// The address in effect.
    pub fn address(&self) -> Address {
        self.address
    }

    /// Tells the board's pages of it.
    pub fn tell(&self, port: &mut BusPort) {
        port.install_parameters(ParameterSet::of(&self.compiled), self.in_effect, &self.stored);
    }

    /// Whether a board could start with `set`.
    ///
    /// # Errors
    /// What to tell the host.
    pub fn check(&self, set: &ParameterSet) -> Result<(), CommitOutcome> {
        set.apply_to(&self.compiled).map(drop).map_err(CommitOutcome::Refused)
    }

    /// Keeps `set`, which has been [checked](Self::check). The board starts with it next time.
    ///
    /// # Errors
    /// The flash does not hold it; what it held before, it does.
    pub fn keep(&self, flash: &mut impl Flash, set: &ParameterSet) -> Result<(), WriteFailed> {
        self.stored.save(flash, set, &ParameterSet::of(&self.compiled)).map(drop)
    }
}
