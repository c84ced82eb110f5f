//! `list`: ports, adapters, and the boards on them.

use crate::args::{BusArgs, ListArgs};
use crate::failure::Failure;
use crate::output::{outln, print_json};
use crate::scan::{self, FoundBoard};
use crate::setup::Setup;
use pneudrive_host::line::{PortInfo, ports};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Report {
    ports: Vec<Port>,
}

/// A port, what is known of its adapter, and its boards where they were asked.
#[derive(Serialize)]
struct Port {
    path: PathBuf,
    adapter: Option<PortInfo>,
    boards: Option<Vec<FoundBoard>>,
    error: Option<String>,
}

/// Lists the ports; with `--scan` or `--port` also asks for boards.
pub fn run(args: &BusArgs, list: &ListArgs, setup: &Setup) -> Result<(), Failure> {
    let known = ports().map_err(|error| Failure::running(format!("/sys/class/tty: {error}")))?;
    let mut listed: Vec<Port> = match &args.port {
        Some(path) => {
            vec![Port { adapter: named(&known, path), path: path.clone(), boards: None, error: None }]
        }
        None => known
            .into_iter()
            .map(|info| Port { path: info.path.clone(), adapter: Some(info), boards: None, error: None })
            .collect(),
    };
    if list.scan || args.port.is_some() {
        let most = args.devices.unwrap_or(args.max_devices.min(255));
        for port in &mut listed {
            match scan::boards(args, &port.path, most, setup) {
                Ok(boards) => port.boards = Some(boards),
                Err(failure) => port.error = Some(failure.to_string()),
            }
        }
    }
    let only = (args.port.is_some()).then(|| listed.iter_mut().find_map(|port| port.error.take())).flatten();
    if let Some(error) = only {
        return Err(Failure::input(error));
    }
    if args.json {
        return print_json(&Report { ports: listed });
    }
    if listed.is_empty() {
        outln!("no serial ports; --port sim is always there");
    }
    listed.iter().for_each(|port| print(port, setup));
    if !listed.is_empty() && !list.scan && args.port.is_none() {
        outln!(
            "--scan lists their boards too. It sends a command of 0 kPa to every port above: leave it out"
        );
        outln!("where one of them has another device, and ask a single port with --port");
    }
    Ok(())
}

fn named(known: &[PortInfo], path: &Path) -> Option<PortInfo> {
    let device = path.canonicalize().ok()?;
    known.iter().find(|info| info.path == device).cloned()
}

fn print(port: &Port, setup: &Setup) {
    outln!("{}", port.path.display());
    if let Some(info) = &port.adapter {
        let serial = info.serial.as_ref().map_or_else(String::new, |serial| format!(", serial {serial}"));
        outln!("  {}{serial}", info.adapter);
        if let Some(link) = &info.by_id {
            outln!("  {}", link.display());
        }
        match info.latency_timer_ms {
            Some(ms) if ms > 1 => {
                outln!("  holds bytes back for up to {ms} ms; set to 1 ms when it is opened, if permitted")
            }
            Some(ms) => outln!("  latency timer {ms} ms"),
            None => {}
        }
    }
    if let Some(error) = &port.error {
        outln!("  {error}");
    }
    let Some(boards) = &port.boards else { return };
    if boards.is_empty() {
        outln!("  no boards");
    }
    for board in boards {
        let kpa =
            board.pressures_kpa.map(|kpa| kpa.map_or_else(|| "-".to_owned(), |kpa| setup.unit.number(kpa)));
        outln!(
            "  {}: {}; {} {} {}",
            setup.board(board.board),
            board.kind(),
            kpa.join(" "),
            setup.unit.name(),
            board.faults()
        );
    }
}
