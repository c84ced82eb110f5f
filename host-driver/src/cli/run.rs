//! Polling: the main job.

use crate::cli::args::{BusArgs, RunArgs};
use crate::cli::command_arg::commands;
use crate::cli::connect::{Behind, Connection, connect, devices, is_sim};
use crate::cli::failure::Failure;
use crate::cli::output::{out, outln};
use crate::cli::output::{print_json, statistics_text};
use crate::cli::signals::StopSignal;
use crate::cli::view::{self, Events, Session};
use crate::cli::{find_boards, sources};
use pneudrive_host::poller::{Finished, Observer, Override, Pace, Poller, PollerOptions};
use pneudrive_host::record::{Recorder, RecordingSummary};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::{Baud, SensorScale};
use serde::Serialize;

/// Statistics as the contract has them, and where the recording is.
#[derive(Serialize)]
struct RunReport<'a> {
    #[serde(flatten)]
    statistics: &'a Statistics,
    recording: Option<RecordingReport>,
}

#[derive(Serialize)]
struct RecordingReport {
    file: String,
    rows: u64,
    bytes: u64,
}

/// Polls until something ends it. Everything in the arguments is checked before the first byte is sent.
pub fn run(args: &BusArgs, run: &RunArgs) -> Result<(), Failure> {
    let devices = devices(args, 1)?;
    let set_points = commands(&run.command, usize::from(devices)).map_err(Failure::input)?;
    let overriding = match &run.trajectory {
        Some(_) => Override::following(set_points.len()),
        None => Override::manual(&set_points),
    };
    let source = overriding.over(sources::source(run, set_points)?);
    let pace = pace(args, run, devices)?;
    if let Some(path) = &run.record {
        Recorder::check(path, run.overwrite)?;
    }
    args.real_time().check()?;
    #[cfg_attr(not(feature = "web"), allow(unused_mut, reason = "only the page listens too"))]
    let mut events = Events::new();
    #[cfg(feature = "web")]
    let mut page = super::web::prepare(&run.web, devices, &overriding, &mut events)?;
    let stop = StopSignal::install()?;
    let Connection { mut bus, behind } = connect(args, devices)?;
    let mut options = PollerOptions {
        pace,
        filter: run.filter,
        real_time: args.real_time(),
        ..PollerOptions::for_devices(devices)
    };
    if run.no_reopen {
        options.reopen = None;
    }
    for (board, error) in find_boards::find(&mut bus, &options.boards, args.wait, || stop.came())? {
        eprintln!("warning: board {board} is missing and will be asked now and then ({error})");
    }
    let mut observers: Vec<Box<dyn Observer>> = Vec::new();
    let recorder = match &run.record {
        Some(path) => {
            let (recorder, tap) =
                Recorder::create(path, &options.boards, SensorScale::ORIGINAL, run.overwrite)?;
            observers.push(tap);
            Some(recorder)
        }
        None => None,
    };
    observers.push(Box::new(events.observer()));
    #[cfg(feature = "web")]
    observers.extend(page.as_mut().and_then(super::web::Prepared::observer));
    let session = Session {
        port: if is_sim(args) { "sim".to_owned() } else { bus.line().path().display().to_string() },
        recording: run.record.clone(),
        clock: bus.line().clock(),
        overriding,
    };
    let poller = Poller::start(bus, options, source, observers)
        .map_err(|error| Failure::running(format!("no thread for the bus: {error}")))?;
    #[cfg(feature = "web")]
    let page = page.map(|page| page.serve(&session, poller.monitor(), &events)).transpose()?;
    let ended = view::show(&session, args.json, run.plain, &poller, &events, || {
        stop.came() || recorder.as_ref().is_some_and(Recorder::has_failed)
    });
    let finished = poller.stop();
    #[cfg(feature = "web")]
    let ended = ended.and(page.map_or(Ok(()), |page| super::web::end(page, finished.as_ref())));
    let recorded = recorder.map(Recorder::finish).transpose();
    conclude(args.json, finished, recorded, ended, behind)
}

/// Prints what there is to print and finds out how it went. The other end of the line goes last.
fn conclude(
    json: bool,
    finished: Option<Finished>,
    recorded: Result<Option<RecordingSummary>, pneudrive_host::record::RecordError>,
    shown: Result<(), Failure>,
    behind: Behind,
) -> Result<(), Failure> {
    let finished = finished.ok_or_else(|| Failure::running("the bus thread panicked; see above"))?;
    let recording = recorded.as_ref().ok().and_then(Option::as_ref);
    if json {
        let recording = recording.map(|r| RecordingReport {
            file: r.file.display().to_string(),
            rows: r.rows,
            bytes: r.bytes,
        });
        print_json(&RunReport { statistics: &finished.statistics, recording })?;
    } else {
        out!("{}", statistics_text(&finished.statistics));
        if let Some(recording) = recording {
            outln!("{}: {} rows, {} bytes", recording.file.display(), recording.rows, recording.bytes);
        }
    }
    behind.end();
    if !finished.not_safe.is_empty() {
        let boards: Vec<_> = finished.not_safe.iter().map(u8::to_string).collect();
        eprintln!(
            "warning: 0 kPa was not confirmed by board(s) {}; they vent by their own command timeout",
            boards.join(", ")
        );
    }
    if let Some(error) = finished.error {
        return Err(Failure::running(error));
    }
    recorded?;
    shown
}

fn pace(args: &BusArgs, run: &RunArgs, devices: u16) -> Result<Pace, Failure> {
    let Some(rate) = run.rate else { return Ok(Pace::AsFastAsPossible) };
    let limit = Baud::new(args.baud).map_err(Failure::input)?.cycle_limit_hz(u32::from(devices));
    if !(rate > 0.0 && rate <= limit) {
        return Err(Failure::input(format!(
            "--rate {rate}: must be above 0 and at most {limit:.1} Hz, the wire's limit for {devices} board(s) at {} baud",
            args.baud
        )));
    }
    let missed = run.missed.map(Into::into).unwrap_or_default();
    Ok(Pace::Every { period_ns: (1e9 / rate).round() as u64, missed })
}
