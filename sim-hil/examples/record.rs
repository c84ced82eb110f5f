//! Makes a recording of the truth plant: the arguments of `pneudrive-sim record` without its other commands.

use std::process::ExitCode;

use clap::Parser;
use pneudrive_sim::record::RecordArgs;

#[derive(Parser)]
struct Args {
    #[command(flatten)]
    record: RecordArgs,
}

fn main() -> ExitCode {
    match Args::parse().record.run() {
        Ok(rows) => {
            println!("{rows} rows");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}
