//! `replay`: a recording's commands once more, or the recording in the views of a run.

use crate::args::{BusArgs, ReplayArgs, RunArgs};
use crate::connect;
use crate::failure::Failure;
use crate::output::outln;
use crate::setup::Setup;
use crate::signals::StopSignal;
use crate::view::{self, EndedBy, Events, Session, Watched};
use pneudrive_host::line::Clock;
use pneudrive_host::poller::Override;
use pneudrive_host::replay::PlayOptions;
use pneudrive_host::rig::{Rig, Unit};
use pneudrive_record::Contents;
use pneudrive_record::replay::{self, Rows};
use std::path::Path;

/// Plays the recording on the boards, or shows it with `--view`.
pub fn run(args: &BusArgs, replay: &ReplayArgs, setup: &Setup) -> Result<(), Failure> {
    let mut run = replay.run.clone();
    let Some(file) = &run.trajectory else {
        return Err(Failure::input("no recording given"));
    };
    if replay.view {
        return look(args, &run, file);
    }
    let mut args = args.clone();
    if args.devices.is_none() {
        let boards = boards(file)?;
        let last = boards.last().copied().unwrap_or(0);
        args.devices = Some(u16::from(last) + 1);
        connect::devices(&args, 1).map_err(|_| {
            Failure::input(format!(
                "{}: it is of boards up to {last}; more than {} boards need --max-devices",
                file.display(),
                args.max_devices
            ))
        })?;
    }
    // As `--from-first-row`: recordings that a button began do not begin at 0.
    run.from_first_row = true;
    super::run::run(&args, &run, setup)
}

/// A recording that cannot be played.
fn refused(file: &Path, error: &std::io::Error) -> Failure {
    let hint = if file.exists() { "" } else { "; a run with `--record FILE` writes one" };
    Failure::input(format!("{}: {error}{hint}", file.display()))
}

/// Numbers of the boards that are recorded.
fn boards(file: &Path) -> Result<Vec<u8>, Failure> {
    let refused = |error: std::io::Error| refused(file, &error);
    let mut rows = Rows::open(file).map_err(refused)?;
    let first = rows.next().transpose().map_err(refused)?;
    let first = first.ok_or_else(|| Failure::input(format!("{}: no rows in it", file.display())))?;
    Ok(first.boards.iter().map(|board| board.board).collect())
}

/// Shows the recording, with the names, unit and limits of the rig file that it has a copy of.
fn look(args: &BusArgs, run: &RunArgs, file: &Path) -> Result<(), Failure> {
    let refused = |error: std::io::Error| refused(file, &error);
    if args.json || run.record.is_some() || run.udp.is_some() || run.preview {
        return Err(Failure::input("--view only shows: without --json, --record, --udp and --preview"));
    }
    let contents = Contents::read(file).map_err(refused)?;
    let rig = copy_of_rig(&contents);
    let unit = args.unit.unwrap_or_else(|| rig.as_ref().map_or_else(Unit::default, Rig::unit));
    let setup = Setup { calibration: replay::calibration(&contents).map_err(refused)?, rig, unit };
    let limits = run.limits.limits(setup.rig.as_ref())?;
    let boards = boards(file)?;
    let stop = StopSignal::install(false)?;
    #[cfg_attr(not(feature = "web"), allow(unused_mut, reason = "only the page listens too"))]
    let mut events = Events::new();
    #[cfg(feature = "web")]
    let page = {
        let description = pneudrive_record::Description::default();
        super::web::prepare(run, &setup, &boards, &limits, None, &description, &mut events)?
    };
    let session = Session {
        port: format!("recording {}", file.display()),
        recording: None,
        clock: Clock,
        overriding: Override::following(boards.len()),
        setup,
        limits,
        recorder: None,
        keep_running: false,
        watch: None,
    };
    let live = view::wants_live(false, run.plain);
    #[cfg(feature = "web")]
    let served = page.is_some();
    #[cfg(not(feature = "web"))]
    let served = false;
    let calibration = session.setup.calibration.clone();
    let options = PlayOptions::new(file.display().to_string(), boards, calibration)
        .speed(run.speed.unwrap_or(1.0))
        .repeat(run.repeat)
        // Whoever looks at lines sees the end by their end.
        .stay(live || served);
    let player = replay::play(file, &contents, options, events.teller()).map_err(refused)?;
    #[cfg(feature = "web")]
    let page = page.map(|page| page.serve(&session, player.monitor(), &events)).transpose()?;
    let until =
        run.duration.map(|seconds| std::time::Instant::now() + std::time::Duration::from_secs_f64(seconds));
    let over = || stop.came() || until.is_some_and(|until| std::time::Instant::now() >= until);
    let shown = view::show(&session, false, run.plain, Watched::Recording(&player), &events, over);
    drop(player);
    #[cfg(feature = "web")]
    if let Some(page) = page {
        page.end(None);
    }
    // What was said too late to be shown.
    std::iter::from_fn(|| events.next()).for_each(|line| crate::output::errln!("{line}"));
    if shown? == EndedBy::Poller {
        outln!("the recording is over");
    }
    Ok(())
}

/// The rig file that was in force, if the recording has it and it can still be read.
fn copy_of_rig(contents: &Contents) -> Option<Rig> {
    let text = |key: &str| contents.description.get(key)?.as_str();
    let (name, text) = (text("rig_file").unwrap_or("rig"), text("rig")?);
    Rig::parse(name, text).map_err(|error| log::warn!("its copy of the rig file: {error}")).ok()
}
