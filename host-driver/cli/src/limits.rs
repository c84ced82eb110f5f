//! `--max-kpa`, `--max-rate-kpa-s` and the rig file: what the channels may be commanded.

use crate::args::number;
use crate::failure::Failure;
use clap::Args;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardCommand, ChannelLimit, Limits};
use pneudrive_host::rig::{self, Rig};

/// Highest set points and fastest changes, on every way in.
#[derive(Debug, Clone, PartialEq, Args, Default)]
#[command(next_help_heading = "Limits")]
pub struct LimitArgs {
    /// Highest set point of every channel, kPa
    ///
    /// What is above it is refused, on the command line, in trajectories and on the page. A rig
    /// file may have others; of several limits the strictest holds.
    #[arg(long, value_name = "KPA", value_parser = number)]
    pub max_kpa: Option<f64>,
    /// Fastest change of every set point, kPa/s
    ///
    /// What is faster is ramped; venting is not slowed down.
    #[arg(long, value_name = "KPA/S", value_parser = number)]
    pub max_rate_kpa_s: Option<f64>,
}

impl LimitArgs {
    /// The limits of `rig` and the command line together.
    pub fn limits(&self, rig: Option<&Rig>) -> Result<Limits, Failure> {
        let limits = rig.map_or(Ok(Limits::default()), rig::limits).map_err(Failure::input)?;
        let own = ChannelLimit {
            max_kpa: self.max_kpa.unwrap_or(f64::INFINITY),
            max_rate_kpa_s: self.max_rate_kpa_s.unwrap_or(f64::INFINITY),
        };
        limits.and(own).map_err(|error| Failure::input(format!("--max-kpa, --max-rate-kpa-s: {error}")))
    }
}

/// Refuses set points above the limits; boards are numbered from 0.
pub fn check(set_points: &[BoardCommand], limits: &Limits, calibration: &Calibration) -> Result<(), Failure> {
    for (board, command) in (0..=u8::MAX).zip(set_points) {
        for (channel, counts) in command.iter().enumerate() {
            let scale = calibration.channel(board, channel);
            let checked = limits.check_counts(board, channel, *counts, scale);
            checked.map_err(|refused| Failure::input(format!("--command: {refused}")))?;
        }
    }
    Ok(())
}
