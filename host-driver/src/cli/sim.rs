//! `--port sim`: virtual boards in a thread of this process. They are talked to through their pty's
//! bytes only.

use crate::cli::args::{BusArgs, SimTiming};
use crate::cli::connect::Punctuality;
use crate::cli::failure::Failure;
use pneudrive_protocol::Baud;
use pneudrive_sim::board::Turnaround;
use pneudrive_sim::pty::{EmbeddedSim, PtyOptions, SimError};
use pneudrive_sim::rig::{RigOptions, Timing};

/// Half of an exchange at 1 Mbaud: the simulator then never sleeps between two exchanges.
const BEST_SPIN_US: u64 = 100;

/// Starts `devices` healthy boards on a line of this rate.
pub fn start(
    args: &BusArgs,
    devices: u16,
    baud: Baud,
    punctuality: Punctuality,
) -> Result<EmbeddedSim, Failure> {
    let rig = RigOptions {
        boards: usize::from(devices),
        baud,
        timing: match args.timing {
            SimTiming::Wire => Timing::Wire,
            SimTiming::Instant => Timing::Instant,
        },
        original: args.sim_original.iter().copied().collect(),
        turnaround: Turnaround::Fixed { delay_ns: args.turnaround_us * 1000 },
        ..RigOptions::default()
    }
    .with_all_sensors();
    let mut options = PtyOptions { past_power_up: true, ..PtyOptions::default() };
    if let Punctuality::Best { dated } = punctuality {
        options.spin_us = BEST_SPIN_US;
        options.dates_back = dated;
    }
    EmbeddedSim::start(&rig, &options).map_err(|error| match error {
        SimError::Rig(_) => Failure::input(format!("virtual boards: {error}")),
        _ => Failure::running(format!("virtual boards: {error}")),
    })
}
