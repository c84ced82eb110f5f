//! What a batch simulates: a model by its name, or a channel that was calibrated.

use super::super::arguments::{self, RigArgument};
use super::super::expected::{Described, Expected};
use super::super::extended::ExtendedModel;
use super::super::parameters::Parameters;
use super::given::setup;
use crate::errors;
use pneudrive_model::data::ChannelId;
use pneudrive_model::diagnosis::ExtendedRollouts;
use pneudrive_model::experiment::{DriveKind, Subject, subject};
use pneudrive_model::model::{FlowForm, Parameter};
use pneudrive_model::rig::Rig;
use pyo3::prelude::*;
use std::sync::Arc;

/// A model as it is given.
#[derive(FromPyObject)]
pub enum ModelArgument {
    Name(String),
    Fitted(Py<Parameters>),
    Extended(Py<ExtendedModel>),
}

impl Described for ModelArgument {
    const EXPECTED: &'static str = "the name of a model, Parameters or an ExtendedModel";
}

/// How a model is simulated.
pub enum Simulator {
    /// In lockstep.
    Lanes { subject: Subject, substeps: usize },
    /// With effects, one by one.
    Effects(Box<ExtendedRollouts>),
}

/// What opens the valves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrivenBy {
    Command,
    Spool,
    Separate,
}

/// A model with its rig and, where it was calibrated, its parameters.
pub struct Plant {
    pub simulator: Simulator,
    pub rig: Arc<Rig>,
    pub driven_by: DrivenBy,
    /// Whether there is a valve, with a supply and a volume.
    pub regulator: bool,
    /// Whether a board's loop is simulated.
    pub controller: bool,
    /// Calibrated values of the parameters.
    pub calibrated: Option<Vec<f64>>,
}

/// How a model is to be simulated, of the arguments.
pub struct Wanted<'a> {
    pub channel: Option<&'a str>,
    pub rig: Option<Expected<RigArgument>>,
    pub controller: Option<bool>,
    pub substeps: Option<i64>,
    /// Are drives of two valves given?
    pub separate: bool,
}

impl Wanted<'_> {
    fn substeps(&self, otherwise: usize) -> PyResult<usize> {
        match self.substeps {
            None => Ok(otherwise),
            Some(count @ 1..=1000) => Ok(usize::try_from(count).unwrap_or(1)),
            Some(count) => Err(errors::unusable(format!("substeps is {count}; it must be 1 to 1000"))),
        }
    }

    /// The channel of a calibrated model: the one that is named, or its only one.
    fn one_of(&self, channels: &[String]) -> PyResult<ChannelId> {
        if self.rig.is_some() {
            return Err(errors::unusable("a calibrated model has its own rig: leave rig out"));
        }
        match (self.channel, channels) {
            (Some(name), _) => name.parse().map_err(errors::unusable),
            (None, [only]) => only.parse().map_err(errors::unusable),
            (None, _) => {
                let names = channels.join(", ");
                Err(errors::unusable(format!("the model has the channels {names}: say which with channel")))
            }
        }
    }
}

impl Plant {
    pub fn new(model: ModelArgument, wanted: Wanted<'_>) -> PyResult<Self> {
        match model {
            ModelArgument::Name(name) => Self::named(&name, wanted),
            ModelArgument::Fitted(parameters) => Self::fitted(parameters.get(), &wanted),
            ModelArgument::Extended(model) => Self::extended(model.get(), &wanted),
        }
    }

    fn named(name: &str, wanted: Wanted<'_>) -> PyResult<Self> {
        let kind = arguments::model(name)?;
        if wanted.channel.is_some() {
            return Err(errors::unusable("channel is for a model that was calibrated"));
        }
        let (substeps, controller) = (wanted.substeps(1)?, wanted.controller.unwrap_or(false));
        let setup = setup(kind, controller, wanted.separate);
        let (rig, _) = RigArgument::resolve(wanted.rig)?;
        let subject = subject(setup, &rig, FlowForm::Iso6358).map_err(errors::unusable)?;
        let regulator = kind.is_regulator();
        let driven_by = match (regulator || controller, wanted.separate) {
            (true, _) => DrivenBy::Command,
            (false, true) => DrivenBy::Separate,
            (false, false) => DrivenBy::Spool,
        };
        let simulator = Simulator::Lanes { subject, substeps };
        Ok(Self { simulator, rig, driven_by, regulator, controller, calibrated: None })
    }

    fn fitted(parameters: &Parameters, wanted: &Wanted<'_>) -> PyResult<Self> {
        let Parameters { file, name } = parameters;
        let channels: Vec<String> = file.channels.keys().map(ToString::to_string).collect();
        let id = wanted.one_of(&channels)?;
        let stored = file.channel(name, id).map_err(errors::store)?;
        let mut setup = stored.setup;
        let regulator = setup.model.is_regulator();
        setup.controller = !regulator && wanted.controller.unwrap_or(setup.controller);
        let rig = Arc::new(file.rig.at(id));
        let subject = subject(setup, &rig, file.flow_form()).map_err(errors::unusable)?;
        let calibrated = Some(file.values(name, id, &subject).map_err(errors::store)?);
        let driven_by = match setup.drive {
            _ if regulator || setup.controller => DrivenBy::Command,
            Some(DriveKind::Separate) => DrivenBy::Separate,
            _ => DrivenBy::Spool,
        };
        let simulator = Simulator::Lanes { subject, substeps: wanted.substeps(stored.substeps)? };
        Ok(Self { simulator, rig, driven_by, regulator, controller: setup.controller, calibrated })
    }

    fn extended(model: &ExtendedModel, wanted: &Wanted<'_>) -> PyResult<Self> {
        let ExtendedModel { file, name } = model;
        let channels: Vec<String> = file.channels.keys().cloned().collect();
        let id = wanted.one_of(&channels)?;
        if wanted.substeps.is_some() {
            let words = "a model with effects is simulated in steps of its own: leave substeps out";
            return Err(errors::unusable(words));
        }
        let rollouts = ExtendedRollouts::new(name, file, id, wanted.controller).map_err(errors::unusable)?;
        let driven_by = match rollouts.driven_by() {
            "spool" => DrivenBy::Spool,
            "separate" => DrivenBy::Separate,
            _ => DrivenBy::Command,
        };
        let regulator = rollouts.driven_by() == "command";
        Ok(Self {
            driven_by,
            regulator,
            controller: rollouts.driven_by() == "board",
            calibrated: Some(rollouts.values().to_vec()),
            rig: Arc::new(file.rig.at(id)),
            simulator: Simulator::Effects(Box::new(rollouts)),
        })
    }

    pub fn parameters(&self) -> Vec<Parameter> {
        self.simulator.parameters()
    }
}

impl Simulator {
    pub fn parameters(&self) -> Vec<Parameter> {
        match self {
            Self::Lanes { subject, .. } => subject.parameters(),
            Self::Effects(rollouts) => rollouts.parameters(),
        }
    }

    /// How long a row takes, in Runge-Kutta steps in lockstep.
    pub fn steps(&self, interval_s: f64) -> usize {
        /// Such steps in the time of one with effects: a hundred nanoseconds.
        const EFFECTS: usize = 10;
        match self {
            Self::Lanes { subject, substeps } => substeps * subject.ticks(interval_s),
            Self::Effects(rollouts) => EFFECTS * rollouts.steps(interval_s),
        }
    }
}
