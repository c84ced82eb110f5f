//! Polling: the main job.

use crate::args::{BusArgs, RunArgs};
use crate::command_arg::commands;
use crate::connect::{Connection, connect, devices, is_sim};
use crate::end_reason::{self, EndReason, Seen};
use crate::failure::Failure;
use crate::limits;
use crate::output::{out, outln};
use crate::output::{print_json, statistics_text};
use crate::recorders::Recorders;
use crate::setup::Setup;
use crate::signals::StopSignal;
use crate::sources::{self, Source};
use crate::stream::UdpStream;
use crate::view::{self, Events, Session};
use crate::{find_boards, preview, start, watch};
use pneudrive_host::Calibration;
use pneudrive_host::poller::{Finished, Observer, Override, Pace, Poller, PollerOptions, PollerPanicked};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::Baud;
use pneudrive_record::watch::Watch;
use pneudrive_record::{Recorder, RecordingSummary};
use pneudrive_virtual::VirtualBoards;
use serde::Serialize;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::SystemTime;

/// Statistics as the contract has them, what run they are of and how it ended, and where the
/// recording is.
#[derive(Serialize)]
struct RunReport<'a> {
    port: &'a str,
    started_utc: &'a str,
    ended: EndReason,
    #[serde(flatten)]
    statistics: &'a Statistics,
    /// Whether every board confirmed 0 kPa at the end; each board's entry has its own.
    zero_kpa_confirmed: bool,
    recording: Option<RecordingReport>,
}

#[derive(Serialize)]
struct RecordingReport {
    file: String,
    rows: u64,
    bytes: u64,
}

/// Polls until something ends it. Everything in the arguments is checked before the first byte is
/// sent.
pub fn run(args: &BusArgs, run: &RunArgs, setup: &Setup) -> Result<(), Failure> {
    let devices = devices(args, 1)?;
    let calibration = &setup.calibration;
    let set_points = commands(&run.command, usize::from(devices), calibration).map_err(Failure::input)?;
    let boards = PollerOptions::for_devices(devices).boards;
    let limits = run.limits.limits(setup.rig.as_ref())?;
    limits::check(&set_points, &limits, calibration)?;
    let overriding = match &run.trajectory {
        Some(_) => Override::following(set_points.len()),
        None => Override::manual(&set_points),
    }
    .with_limits(&boards, limits.clone(), calibration.clone());
    if let Some(record) = &run.record {
        start::not_read_from(record, args, run)?;
    }
    let source = sources::source(run, set_points, &limits, calibration)?;
    if run.preview {
        if args.json {
            return Err(Failure::input("--preview draws: without --json"));
        }
        preview::print(source, usize::from(devices), setup, &limits);
        return Ok(());
    }
    let Source { commands, time_is_over, first_row_s, .. } = source;
    let source = overriding.over(commands);
    let pace = pace(args, run, devices)?;
    if let Some(path) = &run.record {
        Recorder::check(path, run.overwrite)?;
    }
    let stream = run.udp.as_ref().map(|address| UdpStream::to(address, calibration.clone()));
    let stream = stream.transpose().map_err(|error| Failure::input(format!("--udp {error}")))?;
    args.real_time().check()?;
    let description = start::description(args, run, devices, setup, &limits);
    #[cfg_attr(not(feature = "web"), allow(unused_mut, reason = "only the page listens too"))]
    let mut events = Events::new();
    #[cfg(feature = "web")]
    let mut page =
        super::web::prepare(run, setup, &boards, &limits, Some(&overriding), &description, &mut events)?;
    let stop = StopSignal::install(run.keep_running)?;
    let Connection { mut bus, virtual_boards } = connect(args, devices, calibration)?;
    let options = options(args, run, devices, calibration).pace(pace).limits(limits).vent(overriding.latch());
    // Those that are missing are told by the poller, as soon as it has missed them.
    find_boards::find(&mut bus, &options.boards, args.wait, || stop.came())?;
    let mut observers: Vec<Box<dyn Observer>> = Vec::new();
    let recorders =
        Recorders::begin(args, run, (&options.boards, setup), description, &events, &mut observers)?;
    observers.extend(stream.map(|stream| Box::new(stream) as Box<dyn Observer>));
    let watch = watch::start(run, &options.boards, calibration, &events)?;
    let (watch, tap) = watch.map_or((None, None), |(watch, tap)| (Some(watch), Some(tap)));
    observers.extend(tap);
    observers.push(Box::new(events.observer()));
    #[cfg(feature = "web")]
    observers.extend(page.as_mut().and_then(super::web::Prepared::observer));
    let session = Session {
        port: if is_sim(args) { "sim".to_owned() } else { bus.line().path().display().to_string() },
        recording: run.record.clone(),
        clock: bus.line().clock(),
        overriding,
        setup: setup.clone(),
        limits: options.limits.clone(),
        recorder: recorders.by_key(),
        keep_running: run.keep_running,
        watch: watch.as_ref().map(Watch::status),
    };
    start::tell(first_row_s, &events);
    let started_utc = humantime::format_rfc3339_millis(SystemTime::now()).to_string();
    let poller = Poller::start(bus, options, source, observers)?;
    #[cfg(feature = "web")]
    let page = page.map(|page| page.serve(&session, poller.monitor(), &events)).transpose()?;
    let over = || stop.came() || recorders.has_failed();
    let shown = view::show(&session, args.json, run.plain, view::Watched::Boards(&poller), &events, over);
    let seen = Seen {
        ended_by: shown.as_ref().ok().copied(),
        signal: stop.came(),
        time_is_over: time_is_over.load(Ordering::Relaxed),
    };
    let finished = poller.stop();
    if let Some(watch) = watch {
        watch.finish();
    }
    let ended = EndReason::of(&seen, finished.as_ref().ok());
    ended.note(&events.sender(), finished.as_ref().ok());
    #[cfg(feature = "web")]
    let shown = match page.map_or(Ok(()), |page| super::web::end(page, finished.as_ref().ok())) {
        Ok(()) => shown,
        Err(failure) => shown.and(Err(failure)),
    };
    let recorded = recorders.finish();
    // What was said too late to be shown.
    std::iter::from_fn(|| events.next()).for_each(|line| crate::output::errln!("{line}"));
    let about = About { port: &session.port, started_utc: &started_utc, ended };
    let never: Vec<String> = match &finished {
        Ok(finished) if run.require_all => never_answered(finished, setup),
        _ => Vec::new(),
    };
    let concluded = conclude(args.json, &about, finished, recorded, shown, virtual_boards);
    if never.is_empty() {
        return concluded;
    }
    let missed = Failure::running(format!("--require-all: never answered: {}", never.join(", ")));
    // Neither hides the other.
    concluded.inspect_err(|_| crate::output::errln!("error: {missed}")).and(Err(missed.clone()))
}

/// How the bus is polled, as far as arguments say it by themselves.
fn options(args: &BusArgs, run: &RunArgs, devices: u16, calibration: &Calibration) -> PollerOptions {
    let options = PollerOptions::for_devices(devices)
        .calibration(calibration.clone())
        .filter(run.filter)
        .real_time(args.real_time())
        .resume(run.resume)
        .drives(run.drives)
        .sensors(run.sensors)
        .line_rate(args.line_rate());
    if run.no_reopen { options.reopen(None) } else { options }
}

/// Boards that have not answered once.
fn never_answered(finished: &Finished, setup: &Setup) -> Vec<String> {
    let boards = finished.statistics.boards.iter();
    boards.filter(|board| board.answered == 0).map(|board| setup.board(board.board)).collect()
}

/// What a run is called.
struct About<'a> {
    port: &'a str,
    started_utc: &'a str,
    ended: EndReason,
}

/// Prints what there is to print and finds out how it went. The other end of the line goes last.
fn conclude(
    json: bool,
    &About { port, started_utc, ended }: &About<'_>,
    finished: Result<Finished, PollerPanicked>,
    recorded: Result<Option<RecordingSummary>, pneudrive_record::RecordError>,
    shown: Result<view::EndedBy, Failure>,
    virtual_boards: Option<VirtualBoards>,
) -> Result<(), Failure> {
    let finished = finished?;
    let recording = recorded.as_ref().ok().and_then(Option::as_ref);
    if json {
        let recording = recording.map(|r| RecordingReport {
            file: r.file.display().to_string(),
            rows: r.rows,
            bytes: r.bytes,
        });
        let zero_kpa_confirmed = finished.not_safe.is_empty();
        let statistics = &finished.statistics;
        print_json(&RunReport { port, started_utc, ended, statistics, zero_kpa_confirmed, recording })?;
    } else {
        out!("{}", statistics_text(&finished.statistics));
        if let Some(recording) = recording {
            outln!("{}: {} rows, {} bytes", recording.file.display(), recording.rows, recording.bytes);
        }
    }
    drop(virtual_boards);
    end_reason::concluded(&finished)?;
    recorded?;
    shown.map(|_| ())
}

fn pace(args: &BusArgs, run: &RunArgs, devices: u16) -> Result<Pace, Failure> {
    let Some(rate) = run.rate else {
        return match run.missed {
            None => Ok(Pace::AsFastAsPossible),
            Some(_) => Err(Failure::input("--missed needs a rate: --rate, or rate_hz in the rig file")),
        };
    };
    let polls = Baud::new(args.fastest_baud()).map_err(Failure::input)?.cycle_limit_hz(u32::from(devices));
    let limit = polls / (1.0 + run.pages_per_poll());
    if !(rate > 0.0 && rate <= limit) {
        return Err(Failure::input(format!(
            "--rate {rate}: must be above 0 and at most {limit:.1} Hz, the wire's limit for {devices} board(s) at {} baud{}",
            args.fastest_baud(),
            match run.pages_per_poll() {
                0.0 => String::new(),
                pages => format!(" with {pages} page requests for each poll (--drives, --sensors)"),
            }
        )));
    }
    let missed = run.missed.map(Into::into).unwrap_or_default();
    Ok(Pace::Every { period: Duration::from_nanos((1e9 / rate).round() as u64), missed })
}
