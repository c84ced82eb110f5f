//! A kind of part on the connector: found, read, and lost when it fails too often.

use super::{Failure, Master, in_time};
use crate::shared;
use core::marker::PhantomData;
use pneudrive_control::{I2cSensors, Micros};

/// Failures in a row after which a part is not there any more.
const FAILURES: u8 = 3;

/// What is peculiar to a kind of part.
pub(super) trait Part {
    /// What it measures.
    type Reading;
    /// Where it may be.
    const ADDRESSES: &[u8];

    /// Finds out whether it is at an address, and sets it up. Other parts have these addresses,
    /// too: [`Failure::Part`].
    async fn set_up(master: &mut Master<'_>, address: u8) -> Result<(), Failure>;
    /// Reads it.
    async fn measure(master: &mut Master<'_>, address: u8) -> Result<Self::Reading, Failure>;
    /// Tells the board's pages that it is there.
    fn found(sensors: &mut I2cSensors);
    /// Tells them what it has measured.
    fn read(sensors: &mut I2cSensors, now: Micros, reading: Self::Reading);
    /// Tells them that it is gone.
    fn lost(sensors: &mut I2cSensors);
}

/// Where a part is, and how often it has failed in a row.
struct Found {
    address: u8,
    failures: u8,
}

/// A part of some kind, if there is one.
pub(super) struct Sensor<P> {
    found: Option<Found>,
    part: PhantomData<P>,
}

impl<P: Part> Sensor<P> {
    pub(super) const ABSENT: Self = Self { found: None, part: PhantomData };

    /// Looks for one and sets it up, if there is none yet.
    pub(super) async fn look(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        if self.found.is_some() {
            return Ok(());
        }
        for &address in P::ADDRESSES {
            match in_time(P::set_up(master, address)).await {
                Ok(()) => {
                    self.found = Some(Found { address, failures: 0 });
                    shared::with(|shared| P::found(shared.port.sensors()));
                    break;
                }
                Err(Failure::Part) => {}
                Err(Failure::Bus) => return Err(Failure::Bus),
            }
        }
        Ok(())
    }

    /// Reads it, if there is one.
    pub(super) async fn read(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        let Some(found) = &mut self.found else { return Ok(()) };
        match in_time(P::measure(master, found.address)).await {
            Ok(reading) => {
                found.failures = 0;
                let now = shared::now();
                shared::with(|shared| P::read(shared.port.sensors(), now, reading));
                Ok(())
            }
            Err(failure) => {
                shared::with(|shared| shared.port.sensors().error());
                found.failures += 1;
                if found.failures >= FAILURES {
                    self.lose();
                }
                if failure == Failure::Bus { Err(failure) } else { Ok(()) }
            }
        }
    }

    /// It is not there any more.
    pub(super) fn lose(&mut self) {
        self.found = None;
        shared::with(|shared| P::lost(shared.port.sensors()));
    }
}
