//! `--max-kpa`, `--max-rate-kpa-s`, `--rig`: what the channels may be commanded.

use crate::cli::args::number;
use crate::cli::failure::Failure;
use clap::Args;
use pneudrive_host::poller::{BoardCommand, ChannelLimit, Limits};
use pneudrive_host::rig::Rig;
use pneudrive_protocol::SensorScale;
use std::path::PathBuf;

/// Highest set points and fastest changes, on every way in.
#[derive(Debug, Clone, PartialEq, Args, Default)]
#[command(next_help_heading = "Limits")]
pub struct LimitArgs {
    /// Highest set point of every channel, kPa: what is above it is refused, on the command line, in trajectories and on the page
    #[arg(long, value_name = "KPA", value_parser = number)]
    pub max_kpa: Option<f64>,
    /// Fastest change of every set point, kPa/s: what is faster is ramped; venting is not slowed down
    #[arg(long, value_name = "KPA/S", value_parser = number)]
    pub max_rate_kpa_s: Option<f64>,
    /// Rig file, for its limits of boards and channels: [limits], [boards.0.limits], [boards.0.channels.3.limits], each with max_kpa
    /// and max_rate_kpa_s; of several limits the strictest holds
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
}

impl LimitArgs {
    /// The rig file, if there is one.
    pub fn rig(&self) -> Result<Option<Rig>, Failure> {
        self.rig.as_deref().map(Rig::load).transpose().map_err(Failure::input)
    }

    /// The limits of `rig` and the command line together.
    pub fn limits(&self, rig: Option<&Rig>) -> Result<Limits, Failure> {
        let limits = rig.map_or_else(Limits::default, |rig| rig.limits.clone());
        let own = ChannelLimit {
            max_kpa: self.max_kpa.unwrap_or(f64::INFINITY),
            max_rate_kpa_s: self.max_rate_kpa_s.unwrap_or(f64::INFINITY),
        };
        limits.and(own).map_err(|error| Failure::input(format!("--max-kpa, --max-rate-kpa-s: {error}")))
    }
}

/// Refuses set points above the limits; boards are numbered from 0.
pub fn check(set_points: &[BoardCommand], limits: &Limits, scale: SensorScale) -> Result<(), Failure> {
    for (board, command) in (0..=u8::MAX).zip(set_points) {
        for (channel, counts) in command.iter().enumerate() {
            let checked = limits.check_counts(board, channel, *counts, scale);
            checked.map_err(|refused| Failure::input(format!("--command: {refused}")))?;
        }
    }
    Ok(())
}
