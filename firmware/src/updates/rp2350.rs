//! No updates: there is no boot stage for this chip.

use embassy_rp::watchdog::Watchdog;
use pneudrive_control::{BusPort, Micros};

/// There are none: this chip is flashed by a probe or as UF2, and its pages say so.
pub struct Updates;

impl Updates {
    /// Nothing to be known.
    pub fn at_start() -> Self {
        Self
    }

    /// Pages of a board that was told nothing say that it cannot be updated.
    pub fn tell(&self, _port: &mut BusPort) {}

    /// No longer than configured.
    pub fn vent(&self) -> Micros {
        Micros::ZERO
    }

    /// There is nothing to do.
    pub async fn obey(&mut self, _watchdog: &mut Watchdog) {}
}
