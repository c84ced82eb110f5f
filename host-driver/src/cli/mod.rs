//! The command line: one file a subcommand.

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
mod logger;
mod manual;
mod original_client;
mod output;
mod ping;
mod preview;
mod replay;
mod run;
mod scan;
mod setup;
mod signals;
#[cfg(feature = "sim")]
mod sim;
mod sources;
mod start;
mod timing;
mod view;
mod watch;
#[cfg(feature = "web")]
mod web;

use args::{Cli, Command};
use failure::Failure;
use std::process::ExitCode;

/// Reads the arguments, does what they say, returns the exit status: 0 done, 1 failed while running, 2 unusable input.
pub fn main() -> ExitCode {
    logger::install();
    let mut cli = command_line::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    match dispatch(&mut cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            crate::cli::output::errln!("error: {failure}");
            failure.status()
        }
    }
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
        Some(Command::Completions(args)) => manual::completions(args),
        Some(Command::Man(args)) => manual::man(args),
        Some(Command::Ping(args)) => ping::run(&cli.bus, args, &setup),
        Some(Command::Board(args)) => board::run(&cli.bus, args, &setup),
        Some(Command::Timing(args)) => timing::run(&cli.bus, args),
        Some(Command::Generate(args)) => generate::run(&cli.bus, args, &setup),
        Some(Command::Info(args)) => info::run(args, cli.bus.json),
        Some(Command::Replay(args)) => replay::run(&cli.bus, args, &setup),
        Some(Command::Bench(args)) => bench::run(&cli.bus, args),
    }
}
