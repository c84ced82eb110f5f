//! What the program itself lacks: effects hidden in rigs without imperfections, with nothing else
//! asked about. Where the simulation with what is hidden is not as close as the noise then, it is
//! the program that is wrong, and not the recording.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::effects::catalogue::index_of;
use pneudrive_model::rig::Rig;
use system_tests::blind::plan::{CATALOGUE, Case, Kind, SIZES};

use super::Result;
use super::recording::{Extent, record_in};

/// What is made and diagnosed.
pub struct Wanted {
    /// Where the recordings go.
    pub folder: PathBuf,
    /// Number of the size class.
    pub size: usize,
    /// Is the drive recorded?
    pub drive: bool,
    /// Only what hides this effect.
    pub only: Option<String>,
    /// Recordings at once.
    pub at_once: usize,
}

/// Error over the sensor's noise from which on what is hidden is not simulated well.
const CLOSE: f64 = 1.3;
/// Seed of the excitation and the noise: the same in all.
const SEED: u64 = 5;

/// How a diagnosis that was told what to look for has ended.
struct Ended {
    hidden: Vec<String>,
    named: Vec<String>,
    /// Error of the base model and of the extended one on the test blocks, kPa.
    error_kpa: [f64; 2],
    noise_kpa: f64,
}

impl Ended {
    fn is_close(&self) -> bool {
        self.error_kpa[1] <= CLOSE * self.noise_kpa
    }

    fn is_complete(&self) -> bool {
        self.hidden.iter().all(|effect| self.named.contains(effect))
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [before, after] = self.error_kpa;
        let noise = self.noise_kpa;
        let (hidden, named) = (self.hidden.join(", "), self.named.join(", "));
        write!(f, "hidden [{hidden}], named [{named}]: {before:.2} to {after:.2} kPa, noise {noise:.2}")
    }
}

/// Every effect, and every two. Prints what is simulated badly, and what has no name.
pub fn run(wanted: &Wanted) -> Result<()> {
    let cases = cases(wanted);
    if cases.is_empty() {
        return Err("--effect: no such effect in the catalogue".into());
    }
    let (next, ended) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| -> Result<()> {
        let work = || -> std::result::Result<(), String> {
            while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                let one = diagnosed(&wanted.folder, case).map_err(|error| error.to_string())?;
                eprintln!("{one}");
                ended.lock().map_err(|_| "a worker panicked")?.push(one);
            }
            Ok(())
        };
        let workers: Vec<_> = (0..wanted.at_once.max(1)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| Ok(worker.join().map_err(|_| "a worker panicked")??))
    })?;
    let mut ended = ended.into_inner().map_err(|_| "a worker panicked")?;
    ended.sort_by(|a, b| (b.error_kpa[1] / b.noise_kpa).total_cmp(&(a.error_kpa[1] / a.noise_kpa)));
    let (close, far): (Vec<_>, Vec<_>) = ended.iter().partition(|one| one.is_close());
    println!("Further from the pressure than {CLOSE} times the noise: {} of {}", far.len(), ended.len());
    far.iter().for_each(|one| println!("  {one}"));
    let unnamed: Vec<_> = close.into_iter().filter(|one| !one.is_complete()).collect();
    println!("As close as the noise, but not all named: {}", unnamed.len());
    unnamed.iter().for_each(|one| println!("  {one}"));
    Ok(())
}

fn cases(wanted: &Wanted) -> Vec<Case> {
    let mut cases = Vec::new();
    for (k, one) in CATALOGUE.iter().enumerate() {
        for other in &CATALOGUE[k..] {
            let mut hidden = vec![one, other];
            hidden.dedup_by_key(|effect| effect.0);
            if wanted.only.as_ref().is_some_and(|id| hidden.iter().all(|effect| effect.0 != id)) {
                continue;
            }
            cases.push(Case {
                number: cases.len(),
                kind: if hidden.len() == 1 { Kind::Single } else { Kind::Pair },
                effects: hidden.iter().map(|effect| effect.0.to_owned()).collect(),
                arguments: hidden.iter().map(|(id, sizes)| format!("{id}={}", sizes[wanted.size])).collect(),
                size: SIZES[wanted.size].to_owned(),
                seed: SEED,
                drive: wanted.drive,
                hard: None,
            });
        }
    }
    cases
}

fn diagnosed(folder: &Path, case: &Case) -> Result<Ended> {
    let folder = folder.join(case.effects.join("+"));
    record_in(pneudrive_sim::plant::Nuisances::none(), &folder, case, Extent::SHORT)?;
    let rig = Rig::parse("rig.toml", &std::fs::read_to_string(folder.join("rig.toml"))?)?;
    let limits = |channel| rig.sensor_limits(channel);
    let loaded =
        load(&folder.join("run.csv"), LoadOptions { limits: Some(&limits), ..LoadOptions::default() })?;
    let only: Option<Vec<usize>> = case.effects.iter().map(|id| index_of(id)).collect();
    let only = only.ok_or("the truth plant's effects are the catalogue's")?;
    let request = Request { only: &only, ..Request::default() };
    let report = diagnose(&loaded.recording, &rig, request, &|_, _| {})?.report;
    let before_kpa = report.baseline.test_rmse_kpa;
    let after_kpa = report.unexplained.test_rmse_kpa;
    Ok(Ended {
        hidden: case.effects.clone(),
        named: report.causes.into_iter().map(|cause| cause.effect).collect(),
        error_kpa: [before_kpa, after_kpa],
        noise_kpa: report.baseline.noise_floor_kpa,
    })
}
