//! The command line: what there is, and what it means.

mod bus;
mod commands;
mod run;
mod values;

pub use bus::{BusArgs, EchoArg, SessionsArg};
pub use commands::{
    BenchArgs, BoardArgs, BoardCommand, BoardSetArgs, BoardStatusArgs, BoardUpdateArgs, CalibrateArgs,
    CheckArgs, Command, GenerateArgs, InfoArgs, InitArgs, ListArgs, PingArgs, ReplayArgs, ShapeArg,
    TimingArgs,
};
pub use run::RunArgs;
pub use values::number;

use clap::Parser;

/// Below `-h`.
const SHORT: &str = "\
Examples:
  pneudrive-host --port sim --devices 3                          three virtual boards
  pneudrive-host init --port /dev/ttyUSB0                        a rig file for the boards
  pneudrive-host --rig rig.toml --command 100 --record run.csv.zst
--help has all options, examples and exit statuses.";

/// Below `--help`.
const LONG: &str = "\
Examples:
  pneudrive-host --port sim --devices 3                    three virtual boards, on the terminal
  pneudrive-host list                                      serial ports and their adapters
  pneudrive-host init --port /dev/ttyUSB0                  asks for boards and writes rig.toml
  pneudrive-host calibrate --rig rig.toml                  two pressures of each channel, by gauge
  pneudrive-host check --rig rig.toml                      self-test, compared with the first one
  pneudrive-host --rig rig.toml --command 100              all chambers at 100 kPa
  pneudrive-host --rig rig.toml --duration 10 --command 0:50,50,120,120 --record run.csv.zst
  pneudrive-host --port sim --trajectory steps.csv --interpolate linear --record run.csv --json
  pneudrive-host --rig rig.toml --web                      the same in a browser, with a vent button
  pneudrive-host ping --port /dev/ttyUSB0 --devices 4      which boards answer, and how fast
  pneudrive-host board status --port /dev/ttyUSB0 --board 2    its state, faults and firmware
  pneudrive-host timing --baud 460800                      wire times and the 555's resistor
  pneudrive-host bench --port sim --devices 4              the loop rate for 1 to 4 boards
  pneudrive-host info run.csv.zst                          how it was recorded, and what happened
  pneudrive-host replay run.csv.zst --view                 looks at it as it was, without boards
  pneudrive-host replay run.csv.zst --rig rig.toml         commands it again
  pneudrive-host --port /dev/ttyUSB0 --rate 1000 --realtime --lock-memory --pin-core 3

In the live view ? shows the keys; v, V and the space bar vent all boards until r releases them. A run ends on Ctrl-C, SIGTERM, q or Esc
(which asks) in the live view, when the terminal closes, after --duration or a trajectory. Then 0 kPa is commanded to every board, and
the statistics are printed. RUST_LOG=debug says more of what goes on.

Exit status: 0 done, 1 failed while running (a board that may be under pressure did not confirm 0 kPa, a recording failed, or with --require-all
a board never answered), 2 unusable arguments or input.";

/// Polls PneuDrive boards: sends commands, shows and records pressures.
#[derive(Debug, Parser)]
#[command(name = "pneudrive-host", version, after_help = SHORT, after_long_help = LONG, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub bus: BusArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;
    use pneudrive_host::bus::BusOptions;
    use pneudrive_host::real_time::RealTime;
    use pneudrive_protocol::Baud;

    #[test]
    fn the_arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    /// Defaults that the program does not know from the arguments alone stand in their text.
    #[test]
    fn help_states_the_defaults_that_hold() {
        let us = |duration: std::time::Duration| duration.as_micros() as u64;
        let (allowance, virtual_allowance) =
            (us(BusOptions::ANSWER_ALLOWANCE), us(BusOptions::VIRTUAL_ALLOWANCE));
        let mut texts = vec![
            ("allowance_us", format!("[default: {allowance}; {virtual_allowance} for virtual boards")),
            ("baud", format!("[default: {}]", Baud::ORIGINAL.get())),
            ("realtime", format!("[without a number: {}]", RealTime::PRIORITY)),
        ];
        #[cfg(feature = "web")]
        texts.push(("control_limit", format!("[default: {}]", crate::web::WebArgs::CONTROL_LIMIT_KPA)));
        for (argument, text) in texts {
            let command = Cli::command();
            let found = command.get_arguments().find(|found| found.get_id() == argument).unwrap();
            let help = found.get_help().unwrap().to_string();
            assert!(help.contains(&text), "{argument}: {help}");
        }
        let cli = Cli::try_parse_from(["x", "--realtime"]).unwrap();
        assert_eq!(cli.bus.realtime, Some(RealTime::PRIORITY));
        assert_eq!(us(BusOptions::default().late_answer_limit), cli.bus.late_us);
    }

    #[test]
    fn bus_options_may_stand_before_or_behind_the_subcommand() {
        for line in ["x --port sim ping", "x ping --port sim"] {
            let cli = Cli::try_parse_from(line.split(' ')).unwrap();
            assert_eq!(cli.bus.port, Some("sim".into()));
            assert!(matches!(cli.command, Some(Command::Ping(_))) && cli.run.is_default());
        }
    }
}
