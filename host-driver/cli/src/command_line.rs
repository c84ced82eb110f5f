//! What the arguments' definitions cannot say: which bus options a subcommand's help shows, and
//! what is meant by some mistakes.

use crate::args::Cli;
use clap::error::ErrorKind;
use clap::{Arg, Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Options whose value stands behind an equals sign, because it may be left out.
const WITH_EQUALS: [&str; 2] = ["--realtime", "--filter"];

/// Bus options in the help of `ping`; the others act too, and are in the help of the program.
const PING: [&str; 11] =
    ["port", "devices", "rig", "unit", "baud", "allowance_us", "wait", "echo", "frames", "sessions", "json"];
/// Bus options in the help of `list`, `init`, `calibrate` and `check`.
const SCAN: [&str; 7] = ["port", "devices", "rig", "unit", "max_devices", "baud", "wait"];
/// Bus options in the help of `board`.
const BOARD: [&str; 8] = ["port", "rig", "max_devices", "baud", "allowance_us", "wait", "echo", "json"];
/// The same with a JSON object.
const SCAN_JSON: [&str; 8] = ["port", "devices", "rig", "unit", "max_devices", "baud", "wait", "json"];
/// Bus options that matter to `timing`.
const TIMING: [&str; 3] = ["baud", "allowance_us", "json"];

/// Bus options that matter to `info`.
const INFO: [&str; 1] = ["json"];

/// Reads the arguments, the program's name first.
///
/// # Errors
/// What clap says, or something better where it does not see what is meant.
pub fn parse(line: impl IntoIterator<Item = OsString>) -> Result<Cli, clap::Error> {
    let line: Vec<_> = line.into_iter().collect();
    let matches = command().try_get_matches_from(&line).map_err(|error| meant(&line).unwrap_or(error))?;
    Cli::from_arg_matches(&matches)
}

/// The command line's definition, as help, completions and man pages show it.
pub fn command() -> Command {
    // A negative number is a value that is refused with its range, not an option that nobody knows.
    let numbers =
        |arg: Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    let mut command =
        Cli::command().mut_args(numbers).mut_subcommands(|subcommand| subcommand.mut_args(numbers));
    // Now the subcommands have the options of the bus.
    command.build();
    let bus: Vec<_> =
        command.get_arguments().filter(|arg| arg.is_global_set()).map(Arg::get_id).cloned().collect();
    let only = |shown: &'static [&str]| {
        let bus = bus.clone();
        move |arg: Arg| {
            let hidden = bus.contains(arg.get_id()) && !shown.contains(&arg.get_id().as_str());
            if hidden { arg.hide(true) } else { arg }
        }
    };
    command
        .mut_subcommand("ping", |ping| {
            ping.mut_args(only(&PING))
                .after_help("The other options of the bus and the scheduler act too: pneudrive-host --help")
        })
        .mut_subcommand("board", |board| {
            board.mut_args(only(&BOARD)).mut_subcommand("status", |status| status.mut_args(only(&BOARD)))
        })
        .mut_subcommand("list", |list| list.mut_args(only(&SCAN_JSON)))
        .mut_subcommand("init", |init| init.mut_args(only(&SCAN_JSON)))
        .mut_subcommand("calibrate", |calibrate| calibrate.mut_args(only(&SCAN)))
        .mut_subcommand("check", |check| check.mut_args(only(&SCAN_JSON)))
        .mut_subcommand("generate", |generate| generate.mut_args(only(&["devices", "max_devices", "rig"])))
        .mut_subcommand("completions", |completions| completions.mut_args(only(&[])))
        .mut_subcommand("man", |man| man.mut_args(only(&[])))
        .mut_subcommand("info", |info| info.mut_args(only(&INFO)))
        .mut_subcommand("timing", |timing| timing.mut_args(only(&TIMING)))
}

/// The error that tells what is wrong with `line`, where clap's own does not.
fn meant(line: &[OsString]) -> Option<clap::Error> {
    line.windows(2).find_map(|pair| {
        let option = WITH_EQUALS.into_iter().find(|option| pair[0] == *option)?;
        let value = pair[1].to_str().filter(|value| value.parse::<f64>().is_ok())?;
        let message = format!("{option} takes its number behind an equals sign: {option}={value}");
        Some(command().error(ErrorKind::ValueValidation, message))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(line: &str) -> String {
        let words = format!("pneudrive-host {line}");
        parse(words.split(' ').map(OsString::from)).unwrap_err().to_string()
    }

    #[test]
    fn mistakes_are_answered_with_what_is_meant() {
        for (line, message) in [
            ("--port x --realtime 50", "--realtime takes its number behind an equals sign: --realtime=50"),
            ("bench --realtime 50", "--realtime=50"),
            ("--port x --filter 0.5", "--filter=0.5"),
            ("--wait -1", "'--wait <S>': must be above 0 and at most 1e9 s"),
            ("ping --wait -1", "'--wait <S>': must be above 0 and at most 1e9 s"),
            ("ping --count -1", "-1 is not in 1..=1000000"),
            ("--late-us -5", "invalid value '-5' for '--late-us <US>'"),
            ("--rate fast", "'--rate <HZ>': expected a number"),
            ("--max-kpa high", "'--max-kpa <KPA>': expected a number"),
            ("timing --capacitor-nf 1e", "'--capacitor-nf <NF>': expected a number"),
        ] {
            let text = refused(line);
            assert!(text.contains(message), "{line}: {text}");
            assert!(!text.contains("literal"), "{line}: {text}");
        }
        // The number belongs to something else.
        assert!(refused("--realtime nonsense").contains("'nonsense'"));
    }

    #[test]
    fn a_subcommands_help_shows_what_applies_to_it() {
        let help = |name: &str| refused(&format!("{name} --help"));
        let timing = help("timing");
        assert!(timing.contains("--capacitor-nf") && timing.contains("--baud"), "{timing}");
        for absent in ["--port", "--devices", "--wait", "--realtime", "--record"] {
            assert!(!timing.contains(absent), "{absent}: {timing}");
        }
        let ping = help("ping");
        assert!(ping.contains("--count") && ping.contains("--port") && ping.contains("--frames"), "{ping}");
        assert!(!ping.contains("--lock-memory") && !ping.contains("--record"), "{ping}");
        assert!(help("bench").contains("--realtime"));
    }

    /// On a terminal of 24 lines and 80 columns `-h` would scroll; on one of 50 it must not.
    #[test]
    fn the_short_help_is_one_screen() {
        let help = refused("-h");
        let lines = help.lines().count();
        assert!(lines <= 50, "{lines} lines:\n{help}");
        for shown in ["--port", "--rig", "--record", "--web", "calibrate", "--help has all"] {
            assert!(help.contains(shown), "{shown}: {help}");
        }
        assert!(!help.contains("--late-us"), "{help}");
        assert!(refused("--help").contains("--late-us"));
    }

    #[test]
    fn examples_of_the_help_are_whole_lines() {
        assert_eq!(pneudrive_manual::broken_examples(&command()), Vec::<String>::new());
    }

    #[test]
    fn options_that_poll_are_refused_by_what_does_not() {
        assert!(refused("list --record x.csv").contains("--record"));
        assert!(refused("calibrate --channel 4").contains("4 is not in 0..=3"));
        assert!(refused("calibrate --low -1").contains("must be 0 kPa or more"));
        assert!(refused("--unit atm").contains("expected kPa, bar, psi"));
    }

    /// clap reads braces in help texts as its own language.
    #[test]
    fn help_texts_are_whole() {
        let help = refused("--help");
        assert!(help.contains("b0_cmd3_kpa") && !help.contains('{'), "{help}");
    }
}
