//! `--watch`: the calibrated model beside a run.

use crate::args::RunArgs;
use crate::failure::Failure;
use crate::view::Events;
use pneudrive_host::Calibration;
use pneudrive_host::poller::Observer;
use pneudrive_record::PageColumns;
use pneudrive_record::watch::{Watch, WatchError, WatchOptions};
use std::time::Duration;

/// A watch with what sits on the bus for it.
type Watching = (Watch, Box<dyn Observer>);

/// Starts the watch, if there is to be one. What it finds is shown wherever `events` are, and
/// recorded.
pub fn start(
    run: &RunArgs,
    boards: &[u8],
    calibration: &Calibration,
    events: &Events,
) -> Result<Option<Watching>, Failure> {
    let Some(parameters) = &run.watch else { return Ok(None) };
    let options = WatchOptions::new(parameters)
        .program(run.watch_program.clone())
        .learn(run.watch_learn.map(Duration::from_secs_f64))
        .pages(PageColumns { drives: run.drives.is_some(), sensors: run.sensors.is_some() });
    let (mut show, recordings) = (events.teller(), events.sender());
    let tell = move |notice: pneudrive_host::notices::Notice| {
        recordings.note(&notice);
        show(notice.text);
    };
    let failed = |error: WatchError| match error {
        WatchError::NoProgram { .. } => Failure::input(format!("--watch: {error} with --watch-program")),
        error => Failure::input(format!("--watch {error}")),
    };
    Watch::start(&options, boards, calibration, tell).map(Some).map_err(failed)
}
