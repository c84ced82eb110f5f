//! Boards of the simulator.

use crate::{Punctuality, Timing, VirtualError, VirtualOptions};
use pneudrive_sim::board::Turnaround;
use pneudrive_sim::pty::{EmbeddedSim, PtyOptions, SimError};
use pneudrive_sim::rig::{self, RigOptions};
use std::path::Path;

/// Half of an exchange at 1 Mbaud: the simulator then never sleeps between two exchanges.
const BEST_SPIN_US: u64 = 100;

#[derive(Debug)]
pub(crate) struct Boards(EmbeddedSim);

impl Boards {
    pub(crate) fn start(options: &VirtualOptions) -> Result<Self, VirtualError> {
        let usual = RigOptions::default();
        let turnaround = |us: u64| Turnaround::Fixed { delay_ns: us * 1_000 };
        let rig = RigOptions {
            boards: usize::from(options.boards),
            baud: options.baud,
            timing: match options.timing {
                Timing::Wire => rig::Timing::Wire,
                Timing::Instant => rig::Timing::Instant,
            },
            original: options.original.iter().copied().collect(),
            turnaround: options.turnaround_us.map_or(usual.turnaround, turnaround),
            ..usual
        };
        let mut pty = PtyOptions { past_power_up: true, ..PtyOptions::default() };
        if let Punctuality::Best { dated } = options.punctuality {
            pty.spin_us = BEST_SPIN_US;
            pty.dates_back = dated;
        }
        let started = EmbeddedSim::start(&rig.with_all_sensors(), &pty);
        started.map(Self).map_err(|error| match error {
            SimError::Rig(_) => VirtualError::Options(error.to_string()),
            _ => VirtualError::System(error.to_string()),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn pty_round_trip_us(&self) -> f64 {
        self.0.pty_round_trip_us()
    }
}
