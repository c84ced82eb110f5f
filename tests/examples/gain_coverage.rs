//! How often the 95 % interval of a gain contains the gain on ten minutes of the same rig that
//! follow the diagnosed recording.
//!
//! ```text
//! cargo run --release -p system-tests --example gain_coverage -- --rounds 2 --seed 311
//! ```
//!
//! Each recording hides one effect at its moderate size. Effects that depend on the time since the
//! start (drift, wear, a ripple) are left out: the later part starts its own clock.

use std::process::ExitCode;

use pneudrive_model::data::{LoadOptions, Recording, read};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::rig::Rig;
use pneudrive_sim::plant::{Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use system_tests::blind::plan::CATALOGUE;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Length of the diagnosed part and of the part after it, s.
const PARTS_S: [f64; 2] = [220.0, 660.0];
const RATE_HZ: f64 = 100.0;
const LATER_DIFFERENT: [&str; 3] = ["sensor_drift", "valve_wear", "supply_ripple"];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let option = |name: &str, default: u64| {
        let value = arguments.iter().position(|a| a == name).and_then(|k| arguments.get(k + 1));
        value.map_or(Ok(default), |text| text.parse::<u64>())
    };
    match (option("--rounds", 1), option("--seed", 1)) {
        (Ok(rounds), Ok(seed)) => run(rounds, seed).map_or_else(
            |error| {
                eprintln!("error: {error}");
                ExitCode::from(2)
            },
            |()| ExitCode::SUCCESS,
        ),
        _ => {
            eprintln!("usage: gain_coverage [--rounds N] [--seed N]");
            ExitCode::from(2)
        }
    }
}

fn run(rounds: u64, seed: u64) -> Result<()> {
    println!(
        "| hidden | gain | 95 % interval | gain on the 660 s after it | contains it |\n|---|--:|--:|--:|---|"
    );
    let (mut inside, mut all) = (0, 0);
    for k in 0..rounds {
        let steady = CATALOGUE.iter().filter(|(id, _)| !LATER_DIFFERENT.contains(id));
        for (number, (id, sizes)) in steady.enumerate() {
            let effect = format!("{id}={}", sizes[1]);
            // Another noise and another wander every time.
            let Some(line) = one(&effect, 1000 * (seed + k) + number as u64)? else {
                println!("| `{effect}` | | | | nothing named |");
                continue;
            };
            all += 1;
            inside += usize::from(line.contains);
            let [low, high] = line.interval.map(|v| 100.0 * v);
            let (gain, later) = (100.0 * line.gain, 100.0 * line.later);
            let contains = if line.contains { "yes" } else { "no" };
            println!("| `{effect}` | {gain:.1} % | {low:.1} to {high:.1} % | {later:.1} % | {contains} |");
        }
    }
    println!("\n95 % intervals of the gain that contain the later gain: {inside} of {all}");
    Ok(())
}

struct Line {
    gain: f64,
    interval: [f64; 2],
    later: f64,
    contains: bool,
}

/// The gain of everything named in the first part, and what it is in the second; `None` where
/// nothing is named.
fn one(effect: &str, seed: u64) -> Result<Option<Line>> {
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.nuisances = Nuisances::laboratory();
    let settings = RecordingSettings {
        plant,
        effects: vec![effect.parse::<Effect>()?],
        seed,
        seconds: PARTS_S.iter().sum(),
        rate_hz: RATE_HZ,
        control_loop: Loop::Row,
        columns: Columns { drive: true, ..Columns::default() },
        ..defaults
    };
    let file = std::env::temp_dir().join(format!("gain_coverage_{}.csv", std::process::id()));
    write_csv(&file, settings.plant.channels, settings.columns, Recorder::new(&settings)?)?;
    let text = std::fs::read_to_string(&file)?;
    std::fs::remove_file(&file)?;
    let rig = Rig::parse("rig.toml", &rig_toml(&settings)?)?;
    let (first, second) = split(&text, (PARTS_S[0] * RATE_HZ) as usize)?;
    let (first, second) = (recording(&first, &rig)?, recording(&second, &rig)?);
    let diagnosis = diagnose(&first, &rig, Request::default(), &|_, _| {})?;
    if diagnosis.report.causes.is_empty() {
        return Ok(None);
    }
    let here = diagnosis.gain();
    let later = diagnosis.gain_on(&second, &rig)?;
    let contains = (here.ci95[0]..=here.ci95[1]).contains(&later.reduction);
    Ok(Some(Line { gain: here.reduction, interval: here.ci95, later: later.reduction, contains }))
}

/// Cuts a table after a number of rows; both parts keep the head.
fn split(text: &str, rows: usize) -> Result<(String, String)> {
    let head_lines = text.lines().take_while(|l| !l.starts_with(|c: char| c.is_ascii_digit())).count();
    let head: String = text.lines().take(head_lines).map(|l| format!("{l}\n")).collect();
    let body = |from: usize, count: usize| -> String {
        text.lines().skip(head_lines + from).take(count).map(|l| format!("{l}\n")).collect()
    };
    let (first, second) = (body(0, rows), body(rows, usize::MAX));
    if head.is_empty() || second.is_empty() {
        return Err("the recording is shorter than its two parts".into());
    }
    Ok((head.clone() + &first, head + &second))
}

fn recording(text: &str, rig: &Rig) -> Result<Recording> {
    let limits = |channel| rig.sensor_limits(channel);
    let options = LoadOptions { limits: Some(&limits), ..LoadOptions::default() };
    Ok(read("run.csv", text.as_bytes(), options)?.recording)
}
