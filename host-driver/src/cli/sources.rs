//! Where the commands of a run come from.

use crate::cli::args::RunArgs;
use crate::cli::failure::Failure;
use pneudrive_host::poller::{BoardCommand, CommandSource, SetPoints, Supply};
use pneudrive_host::trajectory::{AtEnd, Trajectory};
use pneudrive_protocol::SensorScale;

/// Ends a run after some time.
struct Limited {
    inner: Box<dyn CommandSource>,
    until_ns: u64,
}

impl CommandSource for Limited {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> Supply {
        let supply = self.inner.fill(since_start_ns, commands);
        if since_start_ns >= self.until_ns { Supply::Ended } else { supply }
    }
}

/// The trajectory, or constant set points, for as long as `--duration` says.
pub fn source(run: &RunArgs, set_points: Vec<BoardCommand>) -> Result<Box<dyn CommandSource>, Failure> {
    let inner: Box<dyn CommandSource> = match &run.trajectory {
        None => {
            let points = SetPoints::new(set_points.len());
            for (board, &command) in set_points.iter().enumerate() {
                points.set(board, command).map_err(Failure::input)?;
            }
            Box::new(points)
        }
        Some(path) => {
            let scale = SensorScale::ORIGINAL;
            let trajectory = Trajectory::read(path, set_points.len(), scale).map_err(Failure::input)?;
            let at_end = if run.duration.is_some() { AtEnd::Hold } else { AtEnd::Stop };
            let interpolation = run.interpolate.map(Into::into).unwrap_or_default();
            Box::new(trajectory.play(interpolation, at_end, scale, set_points))
        }
    };
    Ok(match run.duration {
        Some(seconds) => Box::new(Limited { inner, until_ns: (seconds * 1e9) as u64 }),
        None => inner,
    })
}
