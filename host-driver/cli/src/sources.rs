//! Where the commands of a run come from.

use crate::args::RunArgs;
use crate::failure::Failure;
use crate::output::errln;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardCommand, CommandSource, Limits, SetPoints, SourceStatus};
use pneudrive_record::trajectory::{AtEnd, Trajectory};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ends a run after some time.
struct Limited {
    inner: Box<dyn CommandSource>,
    until_ns: u64,
    over: Arc<AtomicBool>,
}

/// Where a run's commands come from, and what there is to know about it.
pub struct Source {
    pub commands: Box<dyn CommandSource>,
    /// Set when the time of `--duration` is over.
    pub time_is_over: Arc<AtomicBool>,
    /// When the trajectory's first row is due, s after the start; `None` without a trajectory.
    pub first_row_s: Option<f64>,
    /// When it ends, s after the start; `None` if it does not. A repeated trajectory: when it
    /// begins anew.
    pub ends_s: Option<f64>,
}

impl CommandSource for Limited {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        let status = self.inner.fill(since_start_ns, commands);
        if since_start_ns < self.until_ns {
            return status;
        }
        self.over.store(true, Ordering::Relaxed);
        SourceStatus::Ended
    }
}

/// The trajectory, or constant set points, for as long as `--duration` says.
pub fn source(
    run: &RunArgs,
    set_points: Vec<BoardCommand>,
    limits: &Limits,
    calibration: &Calibration,
) -> Result<Source, Failure> {
    let time_is_over = Arc::new(AtomicBool::new(false));
    let (mut first_row_s, mut ends_s) = (None, run.duration);
    let inner: Box<dyn CommandSource> = match &run.trajectory {
        None => {
            let points = SetPoints::new(set_points.len());
            for (board, &command) in set_points.iter().enumerate() {
                points.set(board, command).map_err(Failure::input)?;
            }
            Box::new(points)
        }
        Some(path) => {
            let read = if path.as_os_str() == "-" {
                let input = std::io::stdin().lock();
                Trajectory::parse("standard input", input, set_points.len(), calibration.clone())
            } else {
                Trajectory::read(path, set_points.len(), calibration.clone())
            };
            let mut trajectory = read.map_err(|error| {
                let is_missing = path.as_os_str() != "-" && !path.exists();
                let hint = if is_missing { "; `pneudrive-host generate` makes trajectories" } else { "" };
                Failure::input(format!("{error}{hint}"))
            })?;
            if !trajectory.ignored().is_empty() {
                let (file, names) = (path.display(), trajectory.ignored().join(", "));
                errln!("warning: {file}: ignored, for they are no commands (b{{n}}_cmd{{k}}_kpa): {names}");
            }
            if run.from_first_row {
                trajectory = trajectory.from_first_row();
            }
            if let Some(factor) = run.speed {
                trajectory = trajectory.with_speed(factor);
            }
            trajectory
                .check(limits)
                .map_err(|refused| Failure::input(format!("{}: {refused}", path.display())))?;
            first_row_s = Some(trajectory.first_row_s());
            ends_s = ends_s.or(Some(trajectory.seconds()));
            let at_end = match run.duration {
                _ if run.repeat => AtEnd::Repeat,
                Some(_) => AtEnd::Hold,
                None => AtEnd::Stop,
            };
            let interpolation = run.interpolate.map(Into::into).unwrap_or_default();
            Box::new(trajectory.play(interpolation, at_end, calibration.clone(), set_points))
        }
    };
    let commands = match run.duration {
        Some(seconds) => {
            let (until_ns, over) = ((seconds * 1e9) as u64, Arc::clone(&time_is_over));
            Box::new(Limited { inner, until_ns, over })
        }
        None => inner,
    };
    Ok(Source { commands, time_is_over, first_row_s, ends_s })
}
