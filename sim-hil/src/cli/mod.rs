//! The command line of `pneudrive-sim`.

mod lists;
mod run;

use crate::record::RecordArgs;
use clap::{CommandFactory, Parser, Subcommand};
use pneudrive_manual::Manual;
use run::RunArgs;
use std::ffi::OsString;

const ABOUT: &str = "Virtual PneuDrive boards on a virtual RS-485 bus behind a pseudo-terminal";

const EXAMPLES: &str = "\
Examples:
  pneudrive-sim --devices 3 --link /tmp/pneudrive     three healthy boards, then in another terminal:
  pneudrive-host --port /tmp/pneudrive --devices 3
  pneudrive-sim --effect supply_sag=40 --fault bit_flip=1e-4,on=answers --fault unplug@10,board=1
  pneudrive-sim --timing instant                      what the host can do when the wire takes no time
  pneudrive-sim --firmware firmware.elf               the real firmware on emulated chips
  pneudrive-sim --original 0,2                        two of four boards as the original's firmware behaves
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

/// Does what a command line says, the program's name first. Returns the exit status: 0 done, 1 failed while running, 2 unusable
/// arguments. Help and arguments that are none end the process.
pub fn main(line: Vec<OsString>) -> u8 {
    Cli::parse_from(line).execute()
}

impl Cli {
    /// Does what the command line asks for; errors go to standard error. Returns the exit status.
    pub fn execute(&self) -> u8 {
        let result = match &self.command {
            None => self.run.execute(),
            Some(Command::Record(record)) => match record.run() {
                Ok(rows) => {
                    eprintln!("{}: {rows} rows", record.out.display());
                    Ok(())
                }
                Err(error) => Err(Failure { status: error.exit_status(), message: error.to_string() }),
            },
            Some(Command::Effects) => lists::print(&lists::effects()),
            Some(Command::Faults) => lists::print(&lists::faults()),
            Some(Command::Manual(manual)) => manual
                .run(Self::command())
                .map_err(|error| Failure { status: error.exit_status(), message: error.to_string() }),
        };
        match result {
            Ok(()) => 0,
            Err(Failure { status, message }) => {
                eprintln!("pneudrive-sim: {message}");
                status
            }
        }
    }
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
