//! Choices about models and fits that several commands share.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use pneudrive_model::experiment::{ControllerUse, DriveKind, ModelKind, Objective, Split};
use pneudrive_model::fit::{FitOptions, StartPressure};
use pneudrive_model::model::FlowForm;

/// `--model`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelArg(pub ModelKind);

impl ValueEnum for ModelArg {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [ModelArg; ModelKind::ALL.len()] = {
            let mut all = [ModelArg(ModelKind::ALL[0]); ModelKind::ALL.len()];
            let mut k = 1;
            while k < all.len() {
                all[k] = ModelArg(ModelKind::ALL[k]);
                k += 1;
            }
            all
        };
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let about = self.0.about();
        Some(PossibleValue::new(about.id).help(about.title))
    }
}

/// `--controller`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ControllerArg {
    /// Where the drive is not recorded
    Auto,
    /// Always, from commands alone
    On,
    /// Never; the drive must be recorded
    Off,
}

impl From<ControllerArg> for ControllerUse {
    fn from(arg: ControllerArg) -> Self {
        match arg {
            ControllerArg::Auto => Self::Auto,
            ControllerArg::On => Self::On,
            ControllerArg::Off => Self::Off,
        }
    }
}

/// `--drive`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DriveArg {
    /// As the columns say
    Auto,
    /// One spool; recorded fill and vent drives become their difference
    Spool,
    /// Fill and vent with gains of their own
    Separate,
}

impl From<DriveArg> for DriveKind {
    fn from(arg: DriveArg) -> Self {
        match arg {
            DriveArg::Auto => Self::Auto,
            DriveArg::Spool => Self::Spool,
            DriveArg::Separate => Self::Separate,
        }
    }
}

/// `--objective`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveArg {
    /// Simulated against measured pressure, over the whole fitted part
    Rollout,
    /// Model rate against the measured pressure's smoothed derivative: fast, and biased by noise
    Rate,
}

/// `--flow`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FlowArg {
    /// The standard's subsonic flow, sqrt(1 - z^2)
    Iso6358,
    /// As printed in the paper, sqrt(1 - z)
    Printed,
}

/// Which simulation.
#[derive(Debug, clap::Args)]
pub struct SetupArgs {
    /// Simulate the board's own pressure loop ([controller] and [sensor] of the rig)
    #[arg(long, value_enum, default_value_t = ControllerArg::Auto)]
    pub controller: ControllerArg,
    /// Kind of valve
    #[arg(long, value_enum, default_value_t = DriveArg::Auto)]
    pub drive: DriveArg,
    /// Form of the flow function
    #[arg(long, value_enum, default_value_t = FlowArg::Iso6358)]
    pub flow: FlowArg,
}

impl SetupArgs {
    pub fn form(&self) -> FlowForm {
        match self.flow {
            FlowArg::Iso6358 => FlowForm::Iso6358,
            FlowArg::Printed => FlowForm::Printed,
        }
    }
}

/// How to fit.
#[derive(Debug, clap::Args)]
pub struct FitArgs {
    /// What the fit minimises
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Rollout)]
    pub objective: ObjectiveArg,
    /// With --objective rate: samples to either side in the smoothing derivative
    #[arg(long, value_name = "SAMPLES", default_value_t = 2)]
    pub half_width: usize,
    /// Number of starts of each fit
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub starts: u32,
    /// Seed of the starts: the same seed gives the same result
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Take the pressure at the start of each stretch as measured instead of fitting it
    #[arg(long)]
    pub measured_start: bool,
}

impl FitArgs {
    pub fn objective(&self) -> Objective {
        match self.objective {
            ObjectiveArg::Rollout => Objective::Rollout,
            ObjectiveArg::Rate => Objective::Rate { half_width: self.half_width },
        }
    }

    pub fn options(&self, profiles: bool) -> FitOptions {
        FitOptions {
            starts: self.starts as usize,
            seed: self.seed,
            start_pressure: if self.measured_start { StartPressure::Measured } else { StartPressure::Fitted },
            profiles,
            ..FitOptions::default()
        }
    }
}

/// Which part is fitted.
#[derive(Debug, clap::Args)]
#[group(multiple = false)]
pub struct SplitArgs {
    /// Fit the first so many seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    pub fit_seconds: Option<f64>,
    /// Fit the first part of this share of the recording, 0 to 1
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub fit_fraction: Option<f64>,
}

impl SplitArgs {
    pub fn split(&self) -> Option<Split> {
        let seconds = self.fit_seconds.map(Split::FitSeconds);
        seconds.or(self.fit_fraction.map(Split::FitFraction))
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number of seconds above 0".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("expected a share between 0 and 1, both excluded".to_owned()),
    }
}
