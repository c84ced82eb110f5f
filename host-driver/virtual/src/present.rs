//! Boards of the simulator.

use crate::{Punctuality, Timing, VirtualError, VirtualOptions};
use pneudrive_sim::board::Turnaround;
use pneudrive_sim::pty::{EmbeddedSim, PtyOptions, SimError};
use pneudrive_sim::rig::{self, RigOptions};
use std::path::Path;
use std::time::Duration;

/// Half of an exchange at 1 Mbaud: the simulator then never sleeps between two exchanges.
const BEST_SPIN: Duration = Duration::from_micros(100);

#[derive(Debug)]
pub(crate) struct Boards(EmbeddedSim);

impl Boards {
    pub(crate) fn start(options: &VirtualOptions) -> Result<Self, VirtualError> {
        let usual = RigOptions::default();
        let turnaround = |delay: Duration| {
            let delay_ns = u64::try_from(delay.as_nanos()).unwrap_or(u64::MAX);
            Turnaround::Fixed { delay_ns }
        };
        let rig = RigOptions {
            boards: usize::from(options.boards),
            baud: options.baud,
            timing: match options.timing {
                Timing::Wire => rig::Timing::Wire,
                Timing::Instant => rig::Timing::Instant,
            },
            original: options.original.iter().copied().collect(),
            turnaround: options.turnaround.map_or(usual.turnaround, turnaround),
            ..usual
        };
        let mut pty = PtyOptions { past_power_up: true, ..PtyOptions::default() };
        if let Punctuality::Best { dated } = options.punctuality {
            pty.spin = BEST_SPIN;
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

    pub(crate) fn pty_round_trip(&self) -> Duration {
        self.0.pty_round_trip()
    }
}
