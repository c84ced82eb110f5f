//! Times fits of a recording for `benches/compare_lmfit.py`: prints one JSON object per fit with
//! the CPU seconds of one thread.
//!
//! ```sh
//! cargo run --release -p pneudrive-model --example time_fits -- recording.csv rig.toml
//! ```

use std::error::Error;
use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::data::{Needs, series};
use pneudrive_model::fit::{Control, Fit, FitOptions, Problem, Space, fit_rates, fit_rollouts};
use pneudrive_model::model::{Model, Nonlinear};
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::{Chamber, Start, simulate};

/// CPU time of this process's first thread, s.
fn cpu_s() -> Result<f64, Box<dyn Error>> {
    let text = std::fs::read_to_string("/proc/self/schedstat")?;
    let nanoseconds: f64 = text.split_whitespace().next().ok_or("schedstat is empty")?.parse()?;
    Ok(nanoseconds * 1e-9)
}

/// Runs a fit several times, the first of which touches memory and code for the first time: the
/// median of the CPU seconds.
fn median_time(
    repeats: usize,
    mut fit: impl FnMut() -> Result<Fit, Box<dyn Error>>,
) -> Result<(Fit, f64), Box<dyn Error>> {
    let mut seconds = Vec::with_capacity(repeats);
    loop {
        let before = cpu_s()?;
        let result = fit()?;
        seconds.push(cpu_s()? - before);
        if seconds.len() == repeats {
            seconds.sort_by(f64::total_cmp);
            return Ok((result, seconds[repeats / 2]));
        }
    }
}

fn report(name: &str, fit: &Fit, seconds: f64) {
    let values: serde_json::Map<String, serde_json::Value> =
        fit.parameters.iter().map(|p| (p.name.clone(), p.value.into())).collect();
    let line = serde_json::json!({
        "fit": name, "cpu_s": seconds, "rms": fit.rms, "starts": fit.starts.len(),
        "agreeing": fit.agreeing_starts, "evaluations": fit.starts.iter().map(|s| s.evaluations).sum::<usize>(), "parameters": values,
    });
    println!("{line}");
}

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [recording, rig] = paths.as_slice() else {
        return Err("two arguments: recording.csv rig.toml".into());
    };
    // All work on this thread, whose time is measured.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let recording = load(Path::new(recording), LoadOptions::default())?.recording;
    let rig = Rig::load(Path::new(rig))?;
    let needs = Needs { drive: true, pneumatics: true, pressure: true, ..Needs::default() };
    let series = series(&recording, &recording.channels[0], &rig, needs, 0..recording.rows())?;
    let system = Chamber::new(Nonlinear::default());
    let space = || Space::new(system.model.parameters());
    for starts in [1, 20] {
        // One step per sample, as the other side does it.
        let options = FitOptions { starts, integration_tolerance_pa: f64::INFINITY, ..FitOptions::default() };
        let repeats = if starts == 1 { 7 } else { 1 };
        let (fit, seconds) = median_time(repeats, || {
            let problem = Problem { system: &system, series: &series, space: space() };
            Ok(fit_rates(&[problem], 2, &options, Control::none()).remove(0)?)
        })?;
        report("rate", &fit, seconds);
        let (fit, seconds) = median_time(repeats, || {
            let problem = Problem { system: &system, series: &series, space: space() };
            Ok(fit_rollouts(&[problem], &options, Control::none()).remove(0)?)
        })?;
        report("rollout", &fit, seconds);
        if starts == 1 {
            let (values, before) = (fit.values(), cpu_s()?);
            for _ in 0..20 {
                std::hint::black_box(simulate(&system, &values, &series, Start::Measured, 1));
            }
            let rate = 20.0 * series.len() as f64 / (cpu_s()? - before);
            println!("{}", serde_json::json!({"fit": "simulate", "steps_per_s": rate}));
        }
    }
    Ok(())
}
