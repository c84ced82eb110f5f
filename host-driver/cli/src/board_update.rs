//! `board update`: a new program for a board, over the bus.

use crate::args::{BoardUpdateArgs, BusArgs};
use crate::board::{connect_to, explained};
use crate::failure::Failure;
use crate::output::{errln, outln, print_json};
use crate::setup::Setup;
use pneudrive_host::bus::{UpdateError, UpdateProgress, Updated};
use pneudrive_host::program_file::ProgramFile;
use serde::Serialize;
use std::io::IsTerminal;

/// What became of an update.
#[derive(Serialize)]
struct UpdateReport {
    port: String,
    board: u8,
    /// Whether it ran another program before.
    changed: bool,
    /// Version of the program that it runs now.
    firmware: String,
    /// CRC-32 of that, hexadecimal.
    crc: String,
}

/// Brings the board the program in the file.
pub fn update(args: &BusArgs, update: &BoardUpdateArgs, setup: &Setup) -> Result<(), Failure> {
    let path = update.file.display();
    let bytes = std::fs::read(&update.file)
        .map_err(|error| Failure::input(format!("cannot read {path}: {error}")))?;
    let file = ProgramFile::parse(&bytes).map_err(|error| Failure::input(format!("{path}: {error}")))?;
    let board = update.board.board;
    let firmware = file.program().version.map(|number| number.to_string()).join(".");
    let mut connection = connect_to(args, board, setup)?;
    let bus = &mut connection.bus;
    let name = setup.board(board);
    let mut told = None;
    let shows = std::io::stderr().is_terminal();
    let done = bus.update_board(board, &file, |progress| match progress {
        UpdateProgress::Sent { bytes, of } => {
            let percent = 100 * bytes / of;
            // A terminal shows every percent in one line, a log every quarter.
            let step = if shows { percent } else { percent / 25 };
            if told != Some(step) {
                let over = if shows && told.is_some() { "\x1b[A\x1b[2K" } else { "" };
                errln!("{over}{name}: {percent} % of {of} bytes sent");
                told = Some(step);
            }
        }
        UpdateProgress::Writing => errln!("{name}: it writes its flash and restarts"),
        UpdateProgress::Confirming => errln!("{name}: the new program answers, and is told to stay"),
    });
    let changed = done.map_err(|error| Failure::running(of_update(&error)))? == Updated::Done;
    // It vents already, and forgets this host by itself, too.
    let _ = bus.leave(board);
    let port = bus.line().path().display().to_string();
    if args.json {
        let crc = format!("{:08x}", file.crc());
        print_json(&UpdateReport { port, board, changed, firmware, crc })?;
    } else if changed {
        outln!("{name}: runs firmware {firmware}, from now on and after every reset");
    } else {
        outln!("{name}: runs this program already, nothing was sent");
    }
    drop(connection.virtual_boards);
    Ok(())
}

fn of_update(error: &UpdateError) -> String {
    match error {
        UpdateError::Page(error) => explained(error),
        error => error.to_string(),
    }
}
