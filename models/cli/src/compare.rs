//! `pneudrive-model compare`

use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Mutex;

use pneudrive_model::data::{QualityReport, Source, write};
use pneudrive_model::experiment::{
    CompareSettings, CompareWatch, Comparison, ModelKind, Origin, compare, comparison_page, comparison_text,
};
use pneudrive_model::fit::Control;
use pneudrive_model::rig::Rig;
use serde::Serialize;

use super::input::DataArgs;
use super::options::{FitArgs, ModelArg, SetupArgs, SplitArgs};
use super::print::outln;
use super::progress::FitBar;
use super::{Failure, interrupt, origin, output, target};

/// Fit all three models to one part of a recording, judge them on the rest, write a page
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model compare run.csv --rig rig.toml --fit-seconds 200 --out result\n  \
pneudrive-model compare run1.csv --rig ventilator.toml --fit-seconds 15 --out run1\n\n\
Writes compare.html (one self-contained page) and compare.json into the folder, and prints the table.")]
pub struct Args {
    #[command(flatten)]
    input: DataArgs,
    /// Folder for compare.html and compare.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Models [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    models: Vec<ModelArg>,
    #[command(flatten)]
    split: SplitArgs,
    #[command(flatten)]
    setup: SetupArgs,
    #[command(flatten)]
    fit: FitArgs,
}

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    origin: &'a Origin,
    data: &'a Source,
    quality: &'a QualityReport,
    rig: &'a Rig,
    starts: u32,
    seed: u64,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        target::folder("--out", &self.out, &["compare.html", "compare.json"], &self.input.files())?;
        let rig = self.input.load_rig()?;
        let loaded = self.input.load(&rig)?;
        let usual = CompareSettings::default();
        let models: Vec<ModelKind> = self.models.iter().map(|m| m.0).collect();
        let settings = CompareSettings {
            models: if models.is_empty() { usual.models } else { models },
            split: self.split.split().unwrap_or(usual.split),
            objective: self.fit.objective(),
            controller: self.setup.controller.into(),
            drive: self.setup.drive.into(),
            form: self.setup.form(),
            fit: self.fit.options(false),
        };
        let cancel = interrupt::watch()?;
        // One bar per model: `announce` begins a new one, searches in any thread move it.
        let bar: Mutex<Option<FitBar>> = Mutex::new(None);
        let with_bar = |action: &dyn Fn(&FitBar)| {
            if let Ok(bar) = bar.lock() {
                bar.iter().for_each(action);
            }
        };
        let last = RefCell::new(String::new());
        let announce = |model: ModelKind, channels: usize| {
            with_bar(&FitBar::finish);
            *last.borrow_mut() = format!("fitting the {} model to {channels} channel(s)", model.name());
            if channels > 0
                && let Ok(mut bar) = bar.lock()
            {
                *bar = Some(FitBar::new(last.borrow().clone()));
            }
        };
        let progress = |p| with_bar(&|bar| bar.set(p));
        let control = Control { progress: &progress, cancel };
        let watch = CompareWatch { control, clock: &origin::seconds, announce: &announce };
        let comparison = compare(&loaded.recording, &rig, &settings, watch)?;
        with_bar(&FitBar::finish);

        outln!("{}", comparison_text(&comparison));
        let origin = origin::origin();
        let page = comparison_page(&comparison, &loaded.recording, &loaded.quality, &origin)?;
        output::folder(&self.out)?;
        let (html, json) = (self.out.join("compare.html"), self.out.join("compare.json"));
        write::text_atomically(&html, &page)?;
        let content = Output {
            schema: "pneudrive-compare/1",
            origin: &origin,
            data: &loaded.recording.source,
            quality: &loaded.quality,
            rig: &rig,
            starts: self.fit.starts,
            seed: self.fit.seed,
            comparison: &comparison,
        };
        output::json(&json, &content)?;
        outln!("wrote {} and {}", html.display(), json.display());
        interrupt::check("these files")
    }
}
