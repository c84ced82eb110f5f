//! Arguments that several functions share, from Python's words to the library's choices.

use super::expected::{Described, Expected, Names};
use super::rig::Rig;
use crate::errors;
use pneudrive_capi::Control;
use pneudrive_model::experiment::{ControllerUse, DriveKind, ModelKind, Objective, Split};
use pneudrive_model::fit::{FitOptions, StartPressure};
use pneudrive_model::model::FlowForm;
use pneudrive_model::{data, rig};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A rig, or the path of a rig file.
#[derive(FromPyObject)]
pub enum RigArgument {
    Rig(Py<Rig>),
    Path(PathBuf),
}

impl Described for RigArgument {
    const EXPECTED: &'static str = "a Rig or the path of a rig file";
}

impl RigArgument {
    /// The rig with the name of its file; an empty description if none is given.
    pub fn resolve(argument: Option<Expected<Self>>) -> PyResult<(Arc<rig::Rig>, Option<String>)> {
        match argument.map(|Expected(argument)| argument) {
            None => Ok((Arc::default(), None)),
            Some(Self::Rig(rig)) => Ok((Arc::clone(&rig.get().inner), rig.get().file.clone())),
            Some(Self::Path(path)) => {
                let rig = rig::Rig::load(&path).map_err(errors::rig)?;
                Ok((Arc::new(rig), Some(path.display().to_string())))
            }
        }
    }
}

/// The member of `choices` that `word` names.
fn choice<T: Copy>(argument: &str, word: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(name, _)| *name == word);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<String> = choices.iter().map(|(name, _)| format!("{name:?}")).collect();
        errors::unusable(format!("{argument} is {word:?}; it must be {}", names.join(" or ")))
    })
}

pub fn model(word: &str) -> PyResult<ModelKind> {
    choice("model", word, &ModelKind::ALL.map(|kind| (kind.name(), kind)))
}

pub fn controller(word: &str) -> PyResult<ControllerUse> {
    use ControllerUse::{Auto, Off, On};
    choice("controller", word, &[("auto", Auto), ("on", On), ("off", Off)])
}

pub fn drive(word: &str) -> PyResult<DriveKind> {
    use DriveKind::{Auto, Separate, Spool};
    choice("drive", word, &[("auto", Auto), ("spool", Spool), ("separate", Separate)])
}

pub fn control(word: &str) -> PyResult<Control> {
    use Control::{AsCalibrated, Drive, SetPoint};
    choice("control", word, &[("calibrated", AsCalibrated), ("drive", Drive), ("set_point", SetPoint)])
}

pub fn flow(word: &str) -> PyResult<FlowForm> {
    choice("flow", word, &[("iso6358", FlowForm::Iso6358), ("printed", FlowForm::Printed)])
}

/// Samples to either side in the smoothing derivative of a fit of rates, as the command line's.
const HALF_WIDTH: usize = 2;

pub fn objective(word: &str) -> PyResult<Objective> {
    choice(
        "objective",
        word,
        &[("rollout", Objective::Rollout), ("rate", Objective::Rate { half_width: HALF_WIDTH })],
    )
}

/// What is fitted; at most one of the two is given.
pub fn split(fit_seconds: Option<f64>, fit_fraction: Option<f64>) -> PyResult<Option<Split>> {
    match (fit_seconds, fit_fraction) {
        (None, None) => Ok(None),
        (Some(_), Some(_)) => Err(errors::unusable("give fit_seconds or fit_fraction, not both")),
        (Some(s), None) if s > 0.0 && s.is_finite() => Ok(Some(Split::FitSeconds(s))),
        (Some(s), None) => Err(errors::unusable(format!("fit_seconds is {s}; it must be above 0 s"))),
        (None, Some(share)) if share > 0.0 && share < 1.0 => Ok(Some(Split::FitFraction(share))),
        (None, Some(share)) => {
            Err(errors::unusable(format!("fit_fraction is {share}; it must be between 0 and 1")))
        }
    }
}

/// Starts of a fit, at most; the command line allows as many.
const STARTS_MAX: i64 = 10_000;

pub fn fit_options(starts: i64, seed: u64, measured_start: bool, profiles: bool) -> PyResult<FitOptions> {
    if !(1..=STARTS_MAX).contains(&starts) {
        return Err(errors::unusable(format!("starts is {starts}; it must be 1 to {STARTS_MAX}")));
    }
    Ok(FitOptions {
        starts: usize::try_from(starts).unwrap_or(1),
        seed,
        start_pressure: if measured_start { StartPressure::Measured } else { StartPressure::Fitted },
        profiles,
        ..FitOptions::default()
    })
}

/// Names such as "b0c1" as channels.
pub fn channels(names: Expected<Names>) -> PyResult<Vec<data::ChannelId>> {
    names.0.0.into_iter().map(|name| name.parse().map_err(errors::unusable)).collect()
}
