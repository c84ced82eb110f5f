//! `init`: a rig file for the boards that are there.

use crate::args::{BusArgs, InitArgs};
use crate::failure::Failure;
use crate::output::{outln, print_json};
use crate::scan::{self, FoundBoard};
use crate::setup::Setup;
use pneudrive_host::line::{PortInfo, ports};
use pneudrive_rig::NewRig;
use serde::Serialize;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Report<'a> {
    file: &'a Path,
    port: &'a Path,
    boards: &'a [FoundBoard],
}

/// Finds the port, asks for boards, and writes the file. Nothing is replaced.
pub fn run(args: &BusArgs, init: &InitArgs, setup: &Setup) -> Result<(), Failure> {
    let file = &init.file;
    if file.exists() {
        let file = file.display();
        return Err(Failure::input(format!(
            "{file} exists and is not replaced; move it away, or choose another name"
        )));
    }
    let known = ports().unwrap_or_default();
    let port = match &args.port {
        Some(port) => port.clone(),
        None => only_port(&known)?,
    };
    let most = args.devices.unwrap_or(args.max_devices.min(255));
    let found = scan::boards(args, &port, most, setup)?;
    let Some(last) = found.last() else {
        return Err(Failure::running(format!(
            "no board answered on {}; is it powered, and are A and B the right way round?",
            port.display()
        )));
    };
    if let Some(expected) = args.devices {
        let answered = |board: u8| found.iter().any(|one| one.board == board);
        let silent: Vec<_> =
            (0..=u8::MAX).take(usize::from(expected)).filter(|&board| !answered(board)).collect();
        if !silent.is_empty() {
            return Err(missing(file, &port, expected, &silent));
        }
    }
    let known_of = |board: u8| match found.iter().find(|one| one.board == board) {
        Some(one) => one.kind().to_owned(),
        None => "did not answer".to_owned(),
    };
    let lasting = known.iter().find(|info| port.canonicalize().is_ok_and(|path| path == info.path));
    let name = lasting.and_then(|info| info.by_id.clone()).unwrap_or_else(|| port.clone());
    let new = NewRig {
        port: name.display().to_string(),
        baud: args.baud(),
        boards: (0..=last.board).map(known_of).collect(),
        unit: setup.unit,
    };
    let refused = |error: std::io::Error| Failure::input(format!("{}: {error}", file.display()));
    let mut writer = OpenOptions::new().write(true).create_new(true).open(file).map_err(refused)?;
    writer.write_all(new.text().as_bytes()).map_err(refused)?;
    if args.json {
        return print_json(&Report { file, port: &port, boards: &found });
    }
    let names: Vec<_> = found.iter().map(|board| board.board.to_string()).collect();
    outln!("{}: board(s) {} on {}", file.display(), names.join(", "), port.display());
    outln!("next: names and limits in an editor, then pneudrive-host --rig {}", file.display());
    Ok(())
}

/// Whoever says how many there are wants no file that leaves some out.
fn missing(file: &Path, port: &Path, expected: u16, silent: &[u8]) -> Failure {
    let names: Vec<_> = silent.iter().map(u8::to_string).collect();
    Failure::running(format!(
        "of {expected} boards, board(s) {} did not answer on {}; check their power, the two wires and their address switches, or leave \
         --devices out to write {} for those that are there",
        names.join(", "),
        port.display(),
        file.display()
    ))
}

fn only_port(known: &[PortInfo]) -> Result<PathBuf, Failure> {
    match known {
        [only] => Ok(only.path.clone()),
        [] => Err(Failure::input(
            "there is no serial port; plug the adapter in, or use --port sim for virtual boards",
        )),
        several => {
            let names: Vec<_> = several.iter().map(|info| info.path.display().to_string()).collect();
            Err(Failure::input(format!(
                "there are several serial ports ({}): choose with --port; `pneudrive-host list` says what they are",
                names.join(", ")
            )))
        }
    }
}
