//! The channels that are stepped together.

use crate::errors;
use parking_lot::Mutex;
use pneudrive_capi::{Channel, Control, Inputs, Outputs};
use pneudrive_model::experiment::DriveKind;
use pneudrive_model::simulation::CalibratedModel;
use pyo3::prelude::*;
use std::fmt::Display;

/// What a channel follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follows {
    SetPoint,
    Spool,
    Separate,
}

/// What does not change of a channel.
pub struct About {
    pub name: String,
    pub follows: Follows,
    pub nominal: Inputs,
}

impl About {
    fn failed(&self, error: impl Display) -> PyErr {
        errors::unusable(format!("{}: {error}", self.name))
    }
}

/// Channels at the same time.
pub struct Channels {
    about: Vec<About>,
    channels: Mutex<Vec<Channel>>,
}

impl Channels {
    /// Sets them up, at rest at 0 kPa.
    pub fn new(model: &CalibratedModel, names: &[String], step_s: f64, control: Control) -> PyResult<Self> {
        if names.is_empty() {
            return Err(errors::unusable("channels is empty: nothing to simulate"));
        }
        let (mut about, mut channels) = (Vec::new(), Vec::new());
        for name in names {
            let channel = Channel::of(model, name, step_s, control)
                .map_err(|error| errors::unusable(format!("{name}: {error}")))?;
            let follows = follows(model, name, control);
            about.push(About { name: name.clone(), follows, nominal: *channel.nominal() });
            channels.push(channel);
        }
        let all = Self { about, channels: Mutex::new(channels) };
        all.start(|_| 0.0)?;
        Ok(all)
    }

    pub fn about(&self) -> &[About] {
        &self.about
    }

    pub fn number(&self) -> usize {
        self.about.len()
    }

    pub fn start(&self, pressure_kpa: impl Fn(usize) -> f64) -> PyResult<()> {
        for (k, (channel, about)) in self.channels.lock().iter_mut().zip(&self.about).enumerate() {
            channel.start(pressure_kpa(k), &about.nominal).map_err(|error| about.failed(error))?;
        }
        Ok(())
    }

    /// Advances all of them, also beside one that fails: they stay at the same time.
    pub fn step(&self, inputs: &[Inputs]) -> PyResult<()> {
        let mut failed = Ok(());
        let mut channels = self.channels.lock();
        for ((channel, about), inputs) in channels.iter_mut().zip(&self.about).zip(inputs) {
            if let Err(error) = channel.step(inputs) {
                failed = Err(about.failed(error));
            }
        }
        failed
    }

    pub fn outputs(&self, of: impl Fn(&Outputs) -> f64) -> Vec<f64> {
        self.channels.lock().iter().map(|channel| of(channel.outputs())).collect()
    }

    /// The states one after the other.
    pub fn save(&self) -> PyResult<Vec<f64>> {
        let mut state = Vec::new();
        for (channel, about) in self.channels.lock().iter_mut().zip(&self.about) {
            let from = state.len();
            state.resize(from + channel.state_size(), 0.0);
            channel.save(&mut state[from..]).map_err(|error| about.failed(error))?;
        }
        Ok(state)
    }

    pub fn restore(&self, state: &[f64]) -> PyResult<()> {
        let mut channels = self.channels.lock();
        let (found, size) = (state.len(), channels.iter().map(Channel::state_size).sum::<usize>());
        if found != size {
            return Err(errors::unusable(format!("state has {found} numbers; this stepper's has {size}")));
        }
        let mut rest = state;
        for (channel, about) in channels.iter_mut().zip(&self.about) {
            let (own, others) = rest.split_at(channel.state_size());
            channel.restore(own).map_err(|error| about.failed(error))?;
            rest = others;
        }
        Ok(())
    }
}

/// What a channel of a model that was set up follows.
fn follows(model: &CalibratedModel, name: &str, control: Control) -> Follows {
    let (set_point, separate) = match model {
        CalibratedModel::Fitted { file, .. } => {
            let stored =
                file.channels.iter().find(|(id, _)| id.to_string() == name).map(|(_, stored)| stored);
            stored.map_or((false, false), |stored| {
                let setup = stored.setup;
                let regulator = setup.model.is_regulator();
                let set_point = regulator || setup.controller && control != Control::Drive;
                (set_point, setup.drive == Some(DriveKind::Separate))
            })
        }
        CalibratedModel::Extended { file, .. } => {
            let drive = file.channels.get(name).map_or("", |stored| stored.drive.as_str());
            let set_point = matches!(drive, "board" | "command") && control != Control::Drive;
            (set_point, drive == "separate")
        }
    };
    match (set_point || control == Control::SetPoint, separate) {
        (true, _) => Follows::SetPoint,
        (false, true) => Follows::Separate,
        (false, false) => Follows::Spool,
    }
}
