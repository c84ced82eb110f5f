//! The command line of `pneudrive-sim`.

mod lists;
mod run;

use crate::record::RecordArgs;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use pneudrive_manual::Manual;
use run::RunArgs;
use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const ABOUT: &str = "Virtual PneuDrive boards on a virtual RS-485 bus behind a pseudo-terminal";

const EXAMPLES: &str = "\
Examples:
  pneudrive-sim --devices 3 --link /tmp/pneudrive     three healthy boards, then in another terminal:
  pneudrive-host --port /tmp/pneudrive --devices 3
  pneudrive-sim --effect supply_sag=40 --fault bit_flip=1e-4,on=answers --fault unplug@10,board=1
  pneudrive-sim --timing instant                      what the host can do when the wire takes no time
  pneudrive-sim --firmware firmware.elf               the real firmware on emulated chips
  pneudrive-sim --original 0,2                        two boards as in the published PneuDrive
  pneudrive-sim --supply-sensor all --imu 0,1         boards with sensors on their I2C connector
  pneudrive-sim effects                               everything that --effect takes
  pneudrive-sim faults                                everything that --fault takes
  pneudrive-sim record --out run.csv                  a recording without bus and host

The first line on standard output is the path of the port. On SIGTERM, SIGINT or after --duration it ends and
prints one JSON object of bus counters. Exit status: 0 done, 1 failed while running, 2 unusable arguments.";

/// The command line.
#[derive(Debug, Parser)]
#[command(name = "pneudrive-sim", version, about = ABOUT, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Record the truth plant without a bus: the file a host would have written
    Record(Box<RecordArgs>),
    /// List the effects that --effect switches on in the plant, with units
    Effects,
    /// List the faults that --fault injects on the bus, with units and examples
    Faults,
    #[command(flatten)]
    Manual(Manual),
}

/// Does what a command line says, the program's name first. Returns the exit status: 0 done, 1
/// failed while running, 2 unusable arguments. Help and arguments that are none end the process.
pub fn main(line: Vec<OsString>) -> u8 {
    let cli = negative_values(Cli::command()).try_get_matches_from(line);
    let cli = cli.and_then(|matches| Cli::from_arg_matches(&matches));
    cli.unwrap_or_else(|error| error.exit()).execute()
}

impl Cli {
    /// Does what the command line asks for; errors go to standard error. Returns the exit status.
    pub fn execute(&self) -> u8 {
        let result = match &self.command {
            None => self.run.execute(),
            Some(Command::Record(arguments)) => record(arguments),
            Some(Command::Effects) => lists::print(&lists::effects()),
            Some(Command::Faults) => lists::print(&lists::faults()),
            Some(Command::Manual(manual)) => manual
                .run(Self::command())
                .map_err(|error| Failure { status: error.exit_status(), message: error.to_string() }),
        };
        match result {
            Ok(()) => 0,
            Err(Failure { status, message }) => {
                eprintln!("error: {message}");
                status
            }
        }
    }
}

/// Lets `-50` be a value of every option: then its range is what is said to be wrong, not the
/// option's name.
fn negative_values(command: clap::Command) -> clap::Command {
    command
        .mut_args(|arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg })
        .mut_subcommands(negative_values)
}

fn record(arguments: &RecordArgs) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let rows = arguments
        .run(|| stop.load(Ordering::Relaxed))
        .map_err(|error| Failure { status: error.exit_status(), message: error.to_string() })?;
    eprintln!("{}: {rows} rows", arguments.out.display());
    Ok(())
}

/// True after Ctrl-C or SIGTERM.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| Failure::running(format!("cannot handle signal {signal}: {error}")))?;
    }
    Ok(stop)
}

/// Why it ended badly.
struct Failure {
    /// 1 failed while running, 2 unusable arguments.
    status: u8,
    message: String,
}

impl Failure {
    fn running(message: String) -> Self {
        Self { status: 1, message }
    }
}
