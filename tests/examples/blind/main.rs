//! Blind tests of the diagnosis from the command line; docs/diagnosis-trust.md says how to use it.
//!
//! ```text
//! blind generate DIR --rounds 3     recordings and truth.json, by the truth plant alone; --seed 7
//!                                   makes others, --size limit|moderate|gross and
//!                                   --loop drive|closed only some; --hard by a rig with a
//!                                   background of imperfections, which its file describes wrongly;
//!                                   --short a minute of two channels, to make many
//! blind diagnose DIR --program PATH report.json beside each, by the program `pneudrive-model`;
//!                                   --at-once 2 two at a time
//! blind score DIR                   the confusion matrix, from truth.json and report.json, and
//!                                   reliability.svg
//! blind ceiling DIR                 what the program itself lacks: every effect and every two in
//!                                   rigs without imperfections, with nothing else asked about
//! blind table [FILE]                whether the diagnosis still says of fixed recordings what the
//!                                   table says
//! ```

mod ceiling;
mod recording;
mod table;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::{Mutex, PoisonError};

use recording::{Extent, record};
use system_tests::blind::diagram::svg;
use system_tests::blind::plan::{self, Case, SIZES, round};
use system_tests::blind::reliability::Reliability;
use system_tests::blind::score::{Outcome, covered, false_names, matrix, named, score, summary};

const USAGE: &str = "usage: blind COMMAND DIR
  generate DIR [--rounds 1] [--seed 1] [--size limit|moderate|gross] [--loop drive|closed] [--effect ID|none|pairs] [--hard] [--short]
                                            recordings and truth.json, by the truth plant alone; --hard: 50 to
                                            500 Hz, 60 to 300 s, of a rig with a background of imperfections
                                            and a rig file that is off by up to 10 % in volume, 5 % in supply; --short:
                                            60 s of two channels, 100 Hz at most, to make many
  diagnose DIR [--program pneudrive-model] [--at-once 1]
                                            report.json beside each; goes on where it was stopped
  score DIR                                 tables, from truth.json and report.json, and reliability.svg
  ceiling DIR [--loop drive|closed] [--size moderate] [--effect ID] [--at-once 1]
                                            makes and diagnoses every effect and every two, 60 s of two channels without
                                            imperfections, and asks about nothing else; says where the simulation is
                                            not as close as the noise then, and what has no name
  table [FILE] [--share 0.1] [--only TEXT] [--write]
                                            makes and diagnoses the recordings of the committed table and compares: exit status 1
                                            when a name differs or a number moves by more than this share of its interval;
                                            --only those with TEXT in their name (r0, r2c005), --write replaces the table";

/// Rounds that have nothing of what is wanted are no mistake of a disk or a seed.
const NOTHING_MADE: &str = "no recording of these rounds is as wanted. With the drive: rounds 1, 3, 5; closed loop: 2, 4, 6; \
     moderate: 1 and 2, gross: 3 and 4, limit: 5 and 6, and so on: raise --rounds, or see --effect's spelling";

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Exit status where the table says something else.
const DIFFERENT: u8 = 1;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(status) => status,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<ExitCode> {
    let option = |name: &str| arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
    if arguments.iter().any(|a| a == "--help" || a == "-h") {
        println!("{USAGE}");
        return Ok(ExitCode::SUCCESS);
    }
    let path = arguments.get(1).filter(|a| !a.starts_with('-')).map(PathBuf::from);
    if arguments.first().is_some_and(|command| command == "table") {
        let request = table::Request {
            file: path,
            share: option("--share").map_or(Ok(table::SHARE), |text| text.parse())?,
            only: option("--only").cloned(),
            write: arguments.iter().any(|a| a == "--write"),
        };
        let same = table::run(&request)?;
        return Ok(if same { ExitCode::SUCCESS } else { ExitCode::from(DIFFERENT) });
    }
    let directory = path.ok_or(USAGE)?;
    match arguments[0].as_str() {
        "generate" => {
            let rounds: u64 = option("--rounds").map_or(Ok(1), |text| text.parse())?;
            let seed: u64 = option("--seed").map_or(Ok(1), |text| text.parse())?;
            let wanted = |case: &Case| {
                option("--size").is_none_or(|size| *size == case.size)
                    && option("--loop").is_none_or(|kind| (kind == "drive") == case.drive)
                    && option("--effect").is_none_or(|id| hides(case, id))
            };
            let given = |name: &str| arguments.iter().any(|a| a == name);
            let kind = Kind { hard: given("--hard"), short: given("--short") };
            if generate(&directory, seed, rounds, kind, wanted)? == 0 {
                return Err(NOTHING_MADE.into());
            }
        }
        "diagnose" => {
            let at_once: usize = option("--at-once").map_or(Ok(1), |text| text.parse())?;
            diagnose(&directory, option("--program").map_or("pneudrive-model", String::as_str), at_once)?;
        }
        "score" => print_score(&directory)?,
        "ceiling" => {
            let size = option("--size").map_or("moderate", String::as_str);
            ceiling::run(&ceiling::Wanted {
                folder: directory,
                size: SIZES
                    .iter()
                    .position(|known| *known == size)
                    .ok_or("--size is limit, moderate or gross")?,
                drive: match option("--loop").map_or("drive", String::as_str) {
                    "drive" => true,
                    "closed" => false,
                    _ => return Err("--loop is drive or closed".into()),
                },
                only: option("--effect").cloned(),
                at_once: option("--at-once").map_or(Ok(1), |text| text.parse())?,
            })?;
        }
        other => {
            return Err(format!("no command {other}: generate, diagnose, score, ceiling or table").into());
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Which recordings are made of the cases.
#[derive(Clone, Copy)]
struct Kind {
    hard: bool,
    short: bool,
}

/// Whether an effect is among what is hidden in a recording; with `none`, whether nothing is, and
/// with `pairs`, whether two effects are.
fn hides(case: &Case, id: &str) -> bool {
    match id {
        "none" => case.arguments.is_empty(),
        "pairs" => case.kind == plan::Kind::Pair,
        id => case.effects.iter().any(|effect| effect == id),
    }
}

/// Sizes go round: moderate, gross, limit; even rounds record the drive, odd ones close the loop on
/// the board. Returns how many recordings it made.
fn generate(
    directory: &Path,
    seed: u64,
    rounds: u64,
    kind: Kind,
    wanted: impl Fn(&Case) -> bool,
) -> Result<usize> {
    let mut made = 0;
    for k in 0..rounds {
        let size = [1, 2, 0][(k as usize / 2) % SIZES.len()];
        let mut cases = round(seed + k, size, k % 2 == 0);
        if kind.hard {
            cases = plan::hard(seed + k, cases);
        }
        if kind.short {
            cases = plan::short(cases);
        }
        for case in cases.into_iter().filter(&wanted) {
            let folder = directory.join(format!("r{k:03}c{:03}", case.number));
            record(&folder, &case, if kind.short { Extent::SHORT } else { Extent::default() })?;
            println!("{}", folder.display());
            made += 1;
        }
    }
    Ok(made)
}

fn folders(directory: &Path) -> Result<Vec<PathBuf>> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(directory)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|p| p.is_dir())
        .collect();
    folders.sort();
    Ok(folders)
}

fn diagnose(directory: &Path, program: &str, at_once: usize) -> Result<()> {
    let mut left = folders(directory)?;
    left.retain(|folder| !folder.join("report.json").exists());
    left.reverse();
    let left = Mutex::new(left);
    let next = || left.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let worker = || -> std::io::Result<()> {
        while let Some(folder) = next() {
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
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..at_once.max(1)).map(|_| scope.spawn(worker)).collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().map_err(|_| "a worker panicked")?.map_err(Into::into))
    })
}

fn print_score(directory: &Path) -> Result<()> {
    let mut scored: Vec<(Case, Outcome, String)> = Vec::new();
    let (mut inside, mut intervals) = (0, 0);
    // Recordings with a false name, and all: of single effects, and altogether.
    let (mut of_singles, mut of_all) = ([0; 2], [0; 2]);
    let mut reliability = Reliability::default();
    for folder in folders(directory)? {
        let Ok(text) = std::fs::read_to_string(folder.join("report.json")) else {
            continue;
        };
        let case: Case = serde_json::from_str(&std::fs::read_to_string(folder.join("truth.json"))?)?;
        let report: serde_json::Value = serde_json::from_str(&text)?;
        let outcome = score(&case, &report);
        reliability.add(&case, &report);
        let counted = [usize::from(false_names(&case, &report) > 0), 1];
        of_all = [0, 1].map(|k| of_all[k] + counted[k]);
        if case.kind == plan::Kind::Single {
            of_singles = [0, 1].map(|k| of_singles[k] + counted[k]);
        }
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
    println!("false names: in {} of {} recordings", of_all[0], of_all[1]);
    println!("of those with one effect in all channels: in {} of {}", of_singles[0], of_singles[1]);
    println!("95 % intervals of sizes that contain the hidden size: {inside} of {intervals}");
    let diagram = directory.join("reliability.svg");
    std::fs::write(&diagram, svg(&reliability.bins()))?;
    println!("\nProbabilities, drawn in {}:\n{}", diagram.display(), reliability.table());
    Ok(())
}
