//! The command line: one file a subcommand.

mod args;
mod bench;
mod bench_table;
mod command_arg;
mod command_line;
mod connect;
mod end_reason;
mod failure;
mod find_boards;
mod info;
mod limits;
mod logger;
mod original_client;
mod output;
mod ping;
mod run;
mod signals;
#[cfg(feature = "sim")]
mod sim;
mod sources;
mod start;
mod timing;
mod view;
#[cfg(feature = "web")]
mod web;

use args::{Cli, Command};
use failure::Failure;
use std::process::ExitCode;

/// Reads the arguments, does what they say, returns the exit status: 0 done, 1 failed while running, 2 unusable input.
pub fn main() -> ExitCode {
    logger::install();
    let cli = command_line::parse(std::env::args_os()).unwrap_or_else(|error| error.exit());
    match dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            crate::cli::output::errln!("error: {failure}");
            failure.status()
        }
    }
}

fn dispatch(cli: Cli) -> Result<(), Failure> {
    if let Some(command) = &cli.command
        && !cli.run.is_default()
    {
        let name = command.name();
        return Err(Failure::input(format!(
            "options that record or command belong to polling, not to `{name}`"
        )));
    }
    match cli.command {
        None => run::run(&cli.bus, &cli.run),
        Some(Command::Ping(args)) => ping::run(&cli.bus, &args),
        Some(Command::Timing(args)) => timing::run(&cli.bus, &args),
        Some(Command::Info(args)) => info::run(&args, cli.bus.json),
        Some(Command::Bench(args)) => bench::run(&cli.bus, &args),
    }
}
