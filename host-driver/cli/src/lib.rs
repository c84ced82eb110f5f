//! The command line of `pneudrive-host`, for the program of that name and for packages that bring
//! it along: one file a subcommand.
//!
//! What it does on the bus, [`pneudrive_host`] does. Here are the views of a run: the terminal's,
//! [`page`] (feature `web`) and rows as datagrams.
#![forbid(unsafe_code)]

mod args;
mod bench;
mod bench_table;
mod board;
mod board_parameters;
mod board_update;
mod calibrate;
mod check;
mod command_arg;
mod command_line;
mod connect;
mod end_reason;
mod failure;
mod find_boards;
mod generate;
mod info;
mod init;
mod limits;
mod list;
mod load;
mod logger;
mod original_client;
mod output;
#[cfg(feature = "web")]
pub mod page;
mod ping;
mod preview;
mod recorders;
mod replay;
mod run;
mod scan;
mod setup;
mod signals;
mod sources;
mod start;
mod stream;
mod timing;
mod view;
mod watch;
#[cfg(feature = "web")]
mod web;

use args::{Cli, Command};
use failure::Failure;
use std::ffi::OsString;
use std::sync::OnceLock;

/// The command line of this process, the program's name first. Not `std::env::args`: an interpreter
/// may run this.
static LINE: OnceLock<Vec<OsString>> = OnceLock::new();

/// Does what a command line says, the program's name first; once in a process. Returns the exit
/// status: 0 done, 1 failed while running, 2 unusable input. Help and arguments that are none end
/// the process.
pub fn main(line: Vec<OsString>) -> u8 {
    logger::install();
    let line = LINE.get_or_init(|| line);
    let mut cli = command_line::parse(line.iter().cloned()).unwrap_or_else(|error| error.exit());
    match dispatch(&mut cli) {
        // What a run is for are the boards and the recording: a terminal that closes does not make
        // it a failure.
        Ok(()) if matches!(cli.command, None | Some(Command::Replay(_))) => 0,
        Ok(()) => u8::from(output::failed()),
        Err(failure) => {
            crate::output::errln!("error: {failure}");
            failure.status()
        }
    }
}

/// The command line as given.
fn line() -> &'static [OsString] {
    LINE.get().map_or(&[], Vec::as_slice)
}

fn dispatch(cli: &mut Cli) -> Result<(), Failure> {
    if let Some(command) = &cli.command
        && !cli.run.is_default()
    {
        let name = command.name();
        return Err(Failure::input(format!(
            "options that record or command belong to polling, not to `{name}`"
        )));
    }
    let setup = setup::Setup::load(cli)?;
    match &cli.command {
        None => run::run(&cli.bus, &cli.run, &setup),
        Some(Command::List(args)) => list::run(&cli.bus, args, &setup),
        Some(Command::Init(args)) => init::run(&cli.bus, args, &setup),
        Some(Command::Calibrate(args)) => calibrate::run(&cli.bus, args, &setup),
        Some(Command::Check(args)) => check::run(&cli.bus, args, &setup),
        Some(Command::Manual(manual)) => Ok(manual.run(command_line::command())?),
        Some(Command::Ping(args)) => ping::run(&cli.bus, args, &setup),
        Some(Command::Board(args)) => board::run(&cli.bus, args, &setup),
        Some(Command::Timing(args)) => timing::run(&cli.bus, args),
        Some(Command::Generate(args)) => generate::run(&cli.bus, args, &setup),
        Some(Command::Info(args)) => info::run(args, cli.bus.json),
        Some(Command::Replay(args)) => replay::run(&cli.bus, args, &setup),
        Some(Command::Bench(args)) => bench::run(&cli.bus, args),
    }
}
