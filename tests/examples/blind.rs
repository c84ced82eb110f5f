//! Blind tests of the diagnosis from the command line; docs/diagnosis.md says how to use it.
//!
//! ```text
//! blind generate DIR --rounds 3          recordings and truth.json, by the truth plant alone; --seed 7 makes others,
//!                                        --size limit|moderate|gross and --loop drive|closed only some
//! blind diagnose DIR --program PATH      report.json beside each, by the program `pneudrive-model`
//! blind score DIR                        the confusion matrix, from truth.json and report.json
//! ```

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use pneudrive_sim::plant::{Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use system_tests::blind::plan::{Case, SIZES, round};
use system_tests::blind::score::{Outcome, covered, matrix, named, score, summary};

const USAGE: &str = "usage: blind COMMAND DIR
  generate DIR [--rounds 1] [--seed 1] [--size limit|moderate|gross] [--loop drive|closed]
                                            recordings and truth.json, by the truth plant alone
  diagnose DIR [--program pneudrive-model]  report.json beside each; goes on where it was stopped
  score DIR                                 tables, from truth.json and report.json";

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<()> {
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    if arguments.iter().any(|a| a == "--help" || a == "-h") {
        println!("{USAGE}");
        return Ok(());
    }
    let directory = arguments.get(1).filter(|a| !a.starts_with('-')).ok_or(USAGE)?;
    let directory = PathBuf::from(directory);
    match arguments[0].as_str() {
        "generate" => {
            let rounds: u64 = option("--rounds").map_or(Ok(1), |text| text.parse())?;
            let seed: u64 = option("--seed").map_or(Ok(1), |text| text.parse())?;
            let wanted = |case: &Case| {
                option("--size").is_none_or(|size| *size == case.size)
                    && option("--loop").is_none_or(|kind| (kind == "drive") == case.drive)
            };
            generate(&directory, seed, rounds, wanted)
        }
        "diagnose" => diagnose(&directory, option("--program").map_or("pneudrive-model", String::as_str)),
        "score" => print_score(&directory),
        other => Err(format!("no command {other}: generate, diagnose or score").into()),
    }
}

/// Sizes go round: moderate, gross, limit; even rounds record the drive, odd ones close the loop on the board.
fn generate(directory: &Path, seed: u64, rounds: u64, wanted: impl Fn(&Case) -> bool) -> Result<()> {
    for k in 0..rounds {
        let size = [1, 2, 0][(k as usize / 2) % SIZES.len()];
        for case in round(seed + k, size, k % 2 == 0).into_iter().filter(&wanted) {
            let folder = directory.join(format!("r{k:03}c{:03}", case.number));
            record(&folder, &case)?;
            println!("{}", folder.display());
        }
    }
    Ok(())
}

fn record(folder: &Path, case: &Case) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.nuisances = Nuisances::laboratory();
    let effects =
        case.arguments.iter().map(|text| text.parse()).collect::<std::result::Result<Vec<Effect>, _>>()?;
    let settings = RecordingSettings {
        plant,
        effects,
        seed: case.seed,
        seconds: 220.0,
        rate_hz: 100.0,
        control_loop: if case.drive { Loop::Row } else { defaults.control_loop },
        columns: Columns { drive: case.drive, ..Columns::default() },
        ..defaults
    };
    write_csv(&folder.join("run.csv"), settings.plant.channels, settings.columns, Recorder::new(&settings)?)?;
    std::fs::write(folder.join("rig.toml"), rig_toml(&settings)?)?;
    std::fs::write(folder.join("truth.json"), serde_json::to_string_pretty(case)?)?;
    Ok(())
}

fn folders(directory: &Path) -> Result<Vec<PathBuf>> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(directory)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|p| p.is_dir())
        .collect();
    folders.sort();
    Ok(folders)
}

fn diagnose(directory: &Path, program: &str) -> Result<()> {
    for folder in folders(directory)? {
        if folder.join("report.json").exists() {
            continue;
        }
        // Nothing but the data and the nominal rig is handed over.
        let status = Command::new(program)
            .arg("diagnose")
            .arg(folder.join("run.csv"))
            .arg("--rig")
            .arg(folder.join("rig.toml"))
            .arg("--out")
            .arg(&folder)
            .status()?;
        println!("{}: {status}", folder.display());
    }
    Ok(())
}

fn print_score(directory: &Path) -> Result<()> {
    let mut scored: Vec<(Case, Outcome, String)> = Vec::new();
    let (mut inside, mut intervals) = (0, 0);
    for folder in folders(directory)? {
        let Ok(text) = std::fs::read_to_string(folder.join("report.json")) else {
            continue;
        };
        let case: Case = serde_json::from_str(&std::fs::read_to_string(folder.join("truth.json"))?)?;
        let report: serde_json::Value = serde_json::from_str(&text)?;
        let outcome = score(&case, &report);
        if let Some(covers) = covered(&case, &report) {
            inside += usize::from(covers);
            intervals += 1;
        }
        scored.push((case, outcome, named(&report)));
    }
    for (case, outcome, named) in &scored {
        let drive = if case.drive { "drive" } else { "closed loop" };
        println!("{outcome:?}: hidden [{}] ({drive}), named [{named}]", case.arguments.join(", "));
    }
    println!("\n{}\n{}", matrix(&scored), summary(&scored));
    println!("95 % intervals of sizes that contain the hidden size: {inside} of {intervals}");
    Ok(())
}
