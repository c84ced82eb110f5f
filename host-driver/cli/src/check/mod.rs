//! `check`: the self-test on the boards of a bus.

mod baseline;

use crate::args::{BusArgs, CheckArgs};
use crate::connect::{Connection, connect, devices, is_sim};
use crate::end_reason::concluded;
use crate::failure::Failure;
use crate::find_boards;
use crate::limits::LimitArgs;
use crate::output::{errln, out, outln, print_json};
use crate::setup::Setup;
use crate::signals::StopSignal;
use pneudrive_host::check::{BoardPlan, BoardReport, Plan, Report, SelfTest, Verdict, page, problems, table};
use pneudrive_host::poller::{Finished, Limits, Pace, Poller, PollerOptions};
use pneudrive_protocol::{Baud, CHANNELS};
use pneudrive_record::file_is_writable;
use std::time::{Duration, SystemTime};

/// How much of a channel's limit a check goes up to.
const SHARE_OF_LIMIT: f64 = 0.8;
/// Cycles per second where neither the command line nor the rig file says: more than rates and dead
/// times need, and no load.
const USUAL_RATE_HZ: f64 = 500.0;

/// Checks the boards, shows what was found, stores and compares it.
pub fn run(args: &BusArgs, check: &CheckArgs, setup: &Setup) -> Result<(), Failure> {
    let devices = devices(args, 1)?;
    let limits = LimitArgs::default().limits(setup.rig.as_ref())?;
    let plans = plans(check, devices, setup, &limits)?;
    let place = baseline::place(check, setup);
    let earlier = baseline::read(place.as_deref(), check)?;
    let pace = pace(args, check, setup, devices)?;
    if let Some(file) = &check.page {
        file_is_writable(file).map_err(|error| {
            Failure::input(format!("--page {}: nothing can be written there: {error}", file.display()))
        })?;
    }
    baseline::can_be_stored(place.as_deref(), check)?;
    let started_utc = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let (boards, finished) = test(args, (devices, limits, pace), plans, setup, earlier.as_ref())?;
    let port = if is_sim(args) { "sim".into() } else { args.port.clone().unwrap_or_default() };
    let report = Report {
        started_utc,
        port: port.display().to_string(),
        level_kpa: check.level,
        stretch: check.stretch,
        baseline_utc: earlier.map(|earlier| earlier.started_utc),
        verdict: Report::worst(&boards),
        boards,
    };
    let name = |board: u8, channel: Option<usize>| name(setup, board, channel);
    if args.json {
        print_json(&report)?;
    } else {
        out!("{}", table(&report, &name));
        problems(&report, &name).iter().for_each(|problem| outln!("{problem}"));
        outln!("{}", conclusion(&report));
    }
    // Files come last: nothing that was measured is lost with them.
    let paged = check.page.as_ref().map_or(Ok(()), |file| {
        std::fs::write(file, page(&report, &name))
            .map_err(|error| Failure::running(format!("{}: {error}", file.display())))
    });
    let stored = baseline::store(place.as_deref(), check, &report);
    if let Ok(Some(text)) = &stored
        && !args.json
    {
        outln!("{text}");
    }
    let outcomes = [concluded(&finished), paged, stored.map(drop), outcome(&report)];
    let mut failures: Vec<_> = outcomes.into_iter().filter_map(Result::err).collect();
    let last = failures.pop();
    failures.iter().for_each(|failure| errln!("error: {failure}"));
    last.map_or(Ok(()), Err)
}

fn outcome(report: &Report) -> Result<(), Failure> {
    match report.verdict {
        Verdict::Fail => Err(Failure::running("the check failed; see above")),
        _ if report.was_broken_off() => Err(Failure::running("the check was broken off; see above")),
        _ => Ok(()),
    }
}

fn conclusion(report: &Report) -> &'static str {
    match (report.verdict, &report.baseline_utc) {
        (Verdict::Fail, _) => "it does not work as it should",
        _ if report.was_broken_off() => {
            "the check was broken off: it says nothing of boards that it had not finished; check again"
        }
        (Verdict::Pass, Some(_)) => "all is as it was",
        (Verdict::Pass, None) => "all is as it should be; nothing to compare with yet",
        (Verdict::NotMeasured, _) if report.was_disturbed() => {
            "what could be measured is as it should be; what was not, because this machine was too busy or the line lost answers, \
             needs another check (--realtime helps)"
        }
        (Verdict::NotMeasured, _) => "what could be measured is as it should be",
        (Verdict::Warn, _) => "it works, and somebody should look after it",
    }
}

/// `board 0 (shoulder)`, or `board 0 (shoulder), channel 2 (front left)`.
fn name(setup: &Setup, board: u8, channel: Option<usize>) -> String {
    let Some(channel) = channel else { return setup.board(board) };
    let own = setup.channel(board, channel).map_or_else(String::new, |name| format!(" ({name})"));
    format!("{}, channel {channel}{own}", setup.board(board))
}

/// Each board's plan: up to `--level`, or to four fifths of a channel's limit or full scale,
/// whichever is less.
fn plans(check: &CheckArgs, devices: u16, setup: &Setup, limits: &Limits) -> Result<Vec<BoardPlan>, Failure> {
    let boards: Vec<u8> = (0..=u8::MAX).take(usize::from(devices)).collect();
    if let Some(board) = check.board.filter(|board| !boards.contains(board)) {
        return Err(Failure::input(format!(
            "--board {board}: --devices {devices} means boards 0 to {}",
            devices - 1
        )));
    }
    let wanted =
        boards.iter().enumerate().filter(|(_, board)| check.board.is_none_or(|only| only == **board));
    let plan = |(index, &board): (usize, &u8)| {
        let levels: [f64; CHANNELS] = std::array::from_fn(|channel| {
            let full_scale_kpa = setup.calibration.channel(board, channel).full_scale_kpa();
            check.level.min(SHARE_OF_LIMIT * limits.of(board)[channel].max_kpa.min(full_scale_kpa))
        });
        let plan = Plan::new(levels, check.stretch).map_err(|error| {
            Failure::input(format!(
                "{}: {error} (a check goes up to --level, or to four fifths of a channel's limit)",
                setup.board(board)
            ))
        })?;
        Ok(BoardPlan { board, index, plan })
    };
    wanted.map(plan).collect()
}

fn pace(args: &BusArgs, check: &CheckArgs, setup: &Setup, devices: u16) -> Result<Pace, Failure> {
    let wire = Baud::new(args.baud()).map_err(Failure::input)?.cycle_limit_hz(u32::from(devices));
    let usual = setup.rig.as_ref().and_then(|rig| rig.bus().rate_hz).unwrap_or(USUAL_RATE_HZ.min(0.8 * wire));
    let rate = check.rate.unwrap_or(usual);
    if !(rate >= 50.0 && rate <= wire) {
        return Err(Failure::input(format!(
            "--rate {rate}: must be 50 Hz or more, and at most {wire:.1} Hz, the wire's limit for {devices} board(s)"
        )));
    }
    Ok(Pace::every(Duration::from_secs_f64(1.0 / rate)))
}

/// Runs the plans. Whatever happens, 0 kPa is commanded at the end.
fn test(
    args: &BusArgs,
    (devices, limits, pace): (u16, Limits, Pace),
    plans: Vec<BoardPlan>,
    setup: &Setup,
    earlier: Option<&Report>,
) -> Result<(Vec<BoardReport>, Finished), Failure> {
    const LOOK_EVERY: Duration = Duration::from_millis(20);
    args.real_time().check()?;
    let stop = StopSignal::install(false)?;
    let Connection { mut bus, virtual_boards } = connect(args, devices, &setup.calibration)?;
    let options = PollerOptions::for_devices(devices)
        .limits(limits)
        .pace(pace)
        .calibration(setup.calibration.clone())
        .reopen(None)
        .real_time(args.real_time());
    let silent = find_boards::find(&mut bus, &options.boards, args.wait, || stop.came())?;
    if let Some((board, error)) =
        silent.iter().find(|(board, _)| plans.iter().any(|plan| plan.board == *board))
    {
        return Err(Failure::running(format!("{} is missing: {error}", setup.board(*board))));
    }
    let checked: Vec<_> = plans.iter().map(|plan| setup.board(plan.board)).collect();
    let (test, source, watch) = SelfTest::new(plans, &setup.calibration);
    errln!(
        "checking {} for {:.0} s; channels move one at a time; Ctrl-C ends it and vents",
        checked.join(", "),
        test.seconds()
    );
    let poller = Poller::start(bus, options, source, vec![watch])?;
    while !poller.is_finished() {
        if stop.came() {
            test.abort("interrupted");
        }
        std::thread::sleep(LOOK_EVERY);
    }
    let finished = poller.stop()?;
    drop(virtual_boards);
    Ok((test.reports(earlier), finished))
}
