//! `--web`: the live page of a run.

mod args;
pub mod bench;

pub use args::WebArgs;

use super::args::RunArgs;
use super::failure::Failure;
use super::setup::Setup;
use super::view::{Events, Session};
use crate::page::{BoardLabel, Control, Labels, Listener, Recording, Server, Token, UnitLabel, WebOptions};
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{Finished, Limits, Monitor, Observer, Override};
use pneudrive_record::{Description, RecordSwitch, Recorder, RecordingSummary, folder_is_writable};
use std::fs;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

/// An address that is taken and options that are checked, with nobody served yet.
pub struct Prepared {
    listener: Listener,
    options: WebOptions,
    tap: Option<Box<dyn Observer>>,
    token_is_ours: bool,
}

/// Does everything that can fail before the first byte goes to a board. Observers of `events` that
/// shall be heard on the page are made after this. Without `overriding` it is a recording. `None`
/// without `--web`.
pub fn prepare(
    run: &RunArgs,
    setup: &Setup,
    boards: &[u8],
    limits: &Limits,
    overriding: Option<&Override>,
    description: &Description,
    events: &mut Events,
) -> Result<Option<Prepared>, Failure> {
    let args = &run.web;
    let Some(address) = args.web else {
        return Ok(None);
    };
    let control = control(args, setup, boards, limits)?;
    let token_is_ours = control.is_some() && args.control_token_file.is_none();
    let (recording, tap) = recording(run, setup, boards, description, events, overriding.is_none())?;
    let listener = Listener::bind(address).map_err(|error| Failure::input(not_bound(address, &error)))?;
    let notices = events.sender();
    let labels = labels(setup, boards, limits);
    let options = WebOptions {
        port: String::new(),
        boards: boards.to_vec(),
        labels,
        calibration: setup.calibration.clone(),
        names: args.web_name.clone(),
        overriding: overriding.cloned(),
        control,
        recording,
        whole_run: None,
        watch: None,
        lines: Some(Mutex::new(events.listen())),
        notice: Box::new(move |line| notices.happened(Notice::new(NoticeKind::Page, line))),
    };
    Ok(Some(Prepared { listener, options, tap, token_is_ours }))
}

/// With what to give instead where the port is another program's.
fn not_bound(address: SocketAddr, error: &std::io::Error) -> String {
    const NEXT: u16 = 20;
    if error.kind() != std::io::ErrorKind::AddrInUse {
        return format!("--web {address}: {error}; choose another address or port");
    }
    let ports = (1..=NEXT).filter_map(|step| address.port().checked_add(step));
    let free =
        ports.map(|port| SocketAddr::new(address.ip(), port)).find(|next| TcpListener::bind(next).is_ok());
    let example = match free {
        // What a port alone stands for.
        Some(next) if next.ip() == Ipv4Addr::LOCALHOST => format!(", for example --web {}", next.port()),
        Some(next) => format!(", for example --web {next}"),
        None => String::new(),
    };
    format!("--web {address}: another program has this port; choose another{example}")
}

/// Names and unit of the rig file, and where charts end.
fn labels(setup: &Setup, boards: &[u8], limits: &Limits) -> Labels {
    let rig = setup.rig.as_ref();
    let text = |name: Option<&str>| name.map(str::to_owned);
    let board = |&board: &u8| BoardLabel {
        name: text(rig.and_then(|rig| rig.board_name(board))),
        channels: std::array::from_fn(|channel| text(setup.channel(board, channel))),
        scale_kpa: Some(limits.of(board).iter().map(|limit| limit.max_kpa).fold(0.0, f64::max))
            .filter(|kpa| kpa.is_finite() && *kpa > 0.0),
    };
    let unit = setup.unit;
    let unit = UnitLabel { name: unit.name(), kpa: unit.kpa(), decimals: unit.decimals() };
    Labels { unit, boards: boards.iter().map(board).collect() }
}

/// The highest pressure of the page, kPa. The default is no more than the sensors can measure; more
/// than that, asked for, is refused.
fn control_limit(asked_kpa: Option<f64>, full_scale_kpa: f64) -> Result<f64, Failure> {
    match asked_kpa {
        Some(kpa) if kpa > full_scale_kpa => Err(Failure::input(format!(
            "--control-limit {kpa}: at most {full_scale_kpa:.1} kPa, the full scale of the boards' sensors"
        ))),
        Some(kpa) => Ok(kpa),
        None => Ok(WebArgs::CONTROL_LIMIT_KPA.min(full_scale_kpa)),
    }
}

/// The page's sliders end at the highest pressure that any channel may be commanded.
fn control(
    args: &WebArgs,
    setup: &Setup,
    boards: &[u8],
    limits: &Limits,
) -> Result<Option<Control>, Failure> {
    if !args.allow_control {
        return Ok(None);
    }
    let token = match &args.control_token_file {
        None => Token::random().map_err(Failure::running)?,
        Some(file) => {
            let text = fs::read_to_string(file)
                .map_err(|error| Failure::input(format!("{}: {error}", file.display())))?;
            Token::new(text.trim()).map_err(|error| Failure::input(format!("{}: {error}", file.display())))?
        }
    };
    let deadman = args.web_deadman.map(Duration::from_secs_f64);
    let channels = boards.iter().flat_map(|board| limits.of(*board));
    let highest_kpa = channels.map(|limit| limit.max_kpa).fold(0.0, f64::max);
    let limit_kpa = control_limit(args.control_limit, setup.calibration.full_scale_kpa(boards))?;
    let limit_kpa = limit_kpa.min(highest_kpa);
    Ok(Some(Control { token, limit_kpa, deadman }))
}

type RecordingAndTap = (Option<Recording>, Option<Box<dyn Observer>>);

/// The switch for recordings by button, and its end on the bus thread. On an address that others
/// reach, the folder must have been named: there, everybody who sees the page can fill it.
fn recording(
    run: &RunArgs,
    setup: &Setup,
    boards: &[u8],
    description: &Description,
    events: &Events,
    recorded: bool,
) -> Result<RecordingAndTap, Failure> {
    // What is looked at has been recorded.
    if recorded {
        return Ok((None, None));
    }
    let args = &run.web;
    let local = args.web.is_some_and(|address| address.ip().is_loopback());
    let folder = match &args.record_folder {
        None if !local || folder_is_writable(Path::new(".")).is_err() => return Ok((None, None)),
        None => PathBuf::from("."),
        Some(folder) => folder.clone(),
    };
    let folder = folder
        .canonicalize()
        .map_err(|error| Failure::input(format!("--record-folder {}: {error}", folder.display())))?;
    folder_is_writable(&folder).map_err(|error| {
        Failure::input(format!("--record-folder {}: nothing can be written there: {error}", folder.display()))
    })?;
    let ending = args.record_format.ending().to_owned();
    Recorder::check(&folder.join(format!("run.{ending}")), true)?;
    let (pages, ambient_kpa) = (run.pages(), setup.ambient_kpa());
    let (switch, tap) = RecordSwitch::new(boards, setup.calibration.clone());
    let failures = events.sender();
    let switch =
        switch.describe(description.clone()).with_pages(pages, ambient_kpa).on_failure(move |error| {
            let text = format!("a recording from the page failed: {error}");
            failures.happened(Notice::new(NoticeKind::Recording, text));
        });
    events.sender().record(switch.notes());
    Ok((Some(Recording { switch, folder, ending }), Some(tap)))
}

impl Prepared {
    /// What is to be given to the poller.
    pub fn observer(&mut self) -> Option<Box<dyn Observer>> {
        self.tap.take()
    }

    /// Serves the run, and says where.
    pub fn serve(mut self, session: &Session, monitor: Monitor, events: &Events) -> Result<Server, Failure> {
        self.options.port.clone_from(&session.port);
        self.options.whole_run.clone_from(&session.recording);
        self.options.watch.clone_from(&session.watch);
        let address = self.listener.address();
        if !address.ip().is_loopback() {
            events.say(format!(
                "warning: {address} can be reached by others: they can look, vent{}, and what passes between them and this \
                 computer is not encrypted",
                if self.options.recording.is_some() { " and record" } else { "" }
            ));
        }
        let secret = match &self.options.control {
            Some(control) if self.token_is_ours => format!("#token={}", control.token.reveal()),
            _ => String::new(),
        };
        let server = self
            .listener
            .serve(self.options, monitor, session.clock)
            .map_err(|error| Failure::running(format!("--web: {error}")))?;
        events.say(format!("live page: {}{secret}", server.url()));
        if address.ip().is_unspecified() {
            let name = rustix::system::uname();
            let name = name.nodename().to_string_lossy();
            let port = address.port();
            events.say(format!(
                "from elsewhere, where it can be found by its name: http://{name}.local:{port}/{secret}"
            ));
        }
        Ok(server)
    }
}

/// Tells the clients how the run ended, and finishes a recording that was started by button.
pub fn end(server: Server, finished: Option<&Finished>) -> Result<(), Failure> {
    let reason = match finished {
        None => Some("the bus thread panicked".to_owned()),
        Some(finished) => finished.conclusion().failures.into_iter().next(),
    };
    match server.end(reason.as_deref()) {
        Some(Ok(RecordingSummary { file, rows, bytes })) => {
            crate::output::errln!("{}: {rows} rows, {bytes} bytes (recorded from the page)", file.display());
            Ok(())
        }
        Some(Err(error)) => Err(error.into()),
        None => Ok(()),
    }
}
