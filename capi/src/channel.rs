//! One channel with its time.

use std::path::Path;

use pneudrive_model::data::ChannelId;
use pneudrive_model::simulation::CalibratedModel;

use crate::engine::Engine;
use crate::error::{CreateError, StepError};
use crate::inputs::{Control, Inputs};
use crate::outputs::Outputs;
use crate::partials::Partials;
use crate::prepare::{Prepared, prepare};

/// A calibrated channel that is simulated step by step. Nothing but [`create`](Channel::create) and
/// [`of`](Channel::of) allocates.
pub struct Channel {
    engine: Box<dyn Engine>,
    nominal: Inputs,
    step_s: f64,
    started: bool,
    steps: u64,
    outputs: Outputs,
    state_size: usize,
    /// Room for a state.
    kept: Vec<f64>,
}

impl Channel {
    /// Reads a parameter file (of a fit, or `extended.toml` of a diagnosis) and sets up one of its
    /// channels, as in `b0c2`, for steps of `step_s`. Where a set point drives it, a step is a
    /// whole number of the board's loops.
    ///
    /// # Errors
    /// [`CreateError`] that names the file, the channel or the key.
    pub fn create(file: &Path, channel: &str, step_s: f64, control: Control) -> Result<Self, CreateError> {
        Self::of(&CalibratedModel::load(file)?, channel, step_s, control)
    }

    /// As [`create`](Self::create), of a model that was read already.
    ///
    /// # Errors
    /// As there.
    pub fn of(
        model: &CalibratedModel,
        channel: &str,
        step_s: f64,
        control: Control,
    ) -> Result<Self, CreateError> {
        let id: ChannelId = channel.parse().map_err(|error| CreateError::Name(format!("{error}")))?;
        let Prepared { engine, nominal } = prepare(model, id, step_s, control)?;
        let mut outputs = Outputs::default();
        let mut size = FIXED + engine.size();
        outputs.values(&mut |_| size += 1);
        let kept = vec![0.0; size];
        Ok(Self { engine, nominal, step_s, started: false, steps: 0, outputs, state_size: size, kept })
    }

    /// Inputs of a channel at rest: no drive, a set point of 0 kPa, the rig's supply and the volume
    /// of the straight joint, no neighbours.
    #[must_use]
    pub fn nominal(&self) -> &Inputs {
        &self.nominal
    }

    /// Length of a step, s.
    #[must_use]
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Where it stands.
    #[must_use]
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
    }

    /// Begins at rest at a gauge pressure; `inputs` hold at the beginning.
    ///
    /// # Errors
    /// [`StepError::Input`].
    pub fn start(&mut self, pressure_kpa: f64, inputs: &Inputs) -> Result<&Outputs, StepError> {
        inputs.check()?;
        check_pressure(pressure_kpa)?;
        self.outputs = self.engine.start(pressure_kpa, inputs);
        (self.started, self.steps) = (true, 0);
        Ok(&self.outputs)
    }

    /// Advances by a step over which `inputs` hold.
    ///
    /// # Errors
    /// [`StepError`]; where the pressure runs away, the channel must be started or restored anew.
    pub fn step(&mut self, inputs: &Inputs) -> Result<&Outputs, StepError> {
        inputs.check()?;
        if !self.started {
            return Err(StepError::NotStarted);
        }
        let before = self.outputs.pressure_kpa;
        let after = self.engine.step(self.steps, inputs);
        self.steps += 1;
        self.outputs = Outputs {
            #[allow(clippy::cast_precision_loss)] // exact for 285 years of microseconds
            time_s: self.steps as f64 * self.step_s,
            rate_kpa_s: (after.pressure_kpa - before) / self.step_s,
            ..after
        };
        self.started = after.pressure_kpa.is_finite() && after.reading_kpa.is_finite();
        if self.started { Ok(&self.outputs) } else { Err(StepError::RunsAway) }
    }

    /// Moves the pressure in the chamber to this, kPa gauge; what the sensor delivers moves with
    /// it.
    ///
    /// # Errors
    /// [`StepError::Input`], [`StepError::NotStarted`].
    pub fn set_pressure(&mut self, pressure_kpa: f64) -> Result<(), StepError> {
        check_pressure(pressure_kpa)?;
        if !self.started {
            return Err(StepError::NotStarted);
        }
        self.engine.set_pressure(pressure_kpa);
        let change = pressure_kpa - self.outputs.pressure_kpa;
        self.outputs.port_kpa += change;
        self.outputs.reading_kpa += change;
        self.outputs.pressure_kpa = pressure_kpa;
        Ok(())
    }

    /// Numbers in a state.
    #[must_use]
    pub fn state_size(&self) -> usize {
        self.state_size
    }

    /// Writes the whole state: a channel of the same file, name, step and control that takes it
    /// goes on with the same numbers.
    ///
    /// # Errors
    /// [`StepError::State`] when there is not room for exactly [`state_size`](Self::state_size)
    /// numbers.
    pub fn save(&mut self, state: &mut [f64]) -> Result<(), StepError> {
        self.check_size(state)?;
        self.write(state);
        Ok(())
    }

    fn write(&mut self, state: &mut [f64]) {
        let mut rest = state.iter_mut();
        let mut put = |value: f64| {
            if let Some(place) = rest.next() {
                *place = value;
            }
        };
        put(f64::from(u8::from(self.started)));
        #[allow(clippy::cast_precision_loss)] // exact up to 2^53 steps
        put(self.steps as f64);
        self.outputs.values(&mut |value| put(*value));
        self.engine.save(&mut put);
    }

    /// Takes a state back. One that was saved before the start makes a channel that must be
    /// started; so does one of zeros.
    ///
    /// # Errors
    /// [`StepError::State`].
    pub fn restore(&mut self, state: &[f64]) -> Result<(), StepError> {
        self.check_size(state)?;
        self.read(state);
        Ok(())
    }

    fn check_size(&self, state: &[f64]) -> Result<(), StepError> {
        let (found, expected) = (state.len(), self.state_size);
        if found == expected { Ok(()) } else { Err(StepError::State { found, expected }) }
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // written by `write`
    fn read(&mut self, state: &[f64]) {
        let mut rest = state.iter();
        let mut take = || rest.next().copied().unwrap_or(f64::NAN);
        self.started = take() > 0.5;
        self.steps = take() as u64;
        self.outputs.values(&mut |value| *value = take());
        self.engine.restore(&mut take);
    }

    /// How the pressure at the end of a step from here would follow what it begins with. The
    /// channel stays where it is.
    ///
    /// # Errors
    /// As of [`step`](Self::step).
    pub fn partials(&mut self, inputs: &Inputs) -> Result<Partials, StepError> {
        inputs.check()?;
        if !self.started {
            return Err(StepError::NotStarted);
        }
        let mut kept = std::mem::take(&mut self.kept);
        let found = self.differences(inputs, &mut kept);
        self.kept = kept;
        found
    }

    fn differences(&mut self, inputs: &Inputs, kept: &mut [f64]) -> Result<Partials, StepError> {
        let here = self.outputs.pressure_kpa;
        let mut slope = |half: f64, at: &dyn Fn(f64) -> (f64, Inputs)| -> Result<f64, StepError> {
            let mut end = |sign: f64| -> Result<f64, StepError> {
                self.write(kept);
                let (pressure_kpa, inputs) = at(sign * half);
                let moved = if pressure_kpa == here { Ok(()) } else { self.set_pressure(pressure_kpa) };
                let end = moved.and_then(|()| self.step(&inputs).map(|outputs| outputs.pressure_kpa));
                self.read(kept);
                end
            };
            Ok((end(1.0)? - end(-1.0)?) / (2.0 * half))
        };
        let volume = 1e-3 * inputs.volume_m3;
        let rate = volume / 0.1;
        Ok(Partials {
            by_pressure: slope(0.05, &|d| (here + d, *inputs))?,
            by_fill: slope(5e-4, &|d| (here, Inputs { fill: inputs.fill + d, ..*inputs }))?,
            by_vent: slope(5e-4, &|d| (here, Inputs { vent: inputs.vent + d, ..*inputs }))?,
            by_set_point: slope(2.0, &|d| {
                (here, Inputs { set_point_kpa: inputs.set_point_kpa + d, ..*inputs })
            })?,
            by_supply: slope(0.05, &|d| (here, Inputs { supply_kpa: inputs.supply_kpa + d, ..*inputs }))?,
            by_volume: slope(0.5 * volume, &|d| {
                (here, Inputs { volume_m3: inputs.volume_m3 + d, ..*inputs })
            })?,
            by_volume_rate: slope(rate, &|d| {
                (here, Inputs { volume_rate_m3_s: inputs.volume_rate_m3_s + d, ..*inputs })
            })?,
        })
    }
}

/// Numbers in a state beside the outputs and the engine's own.
const FIXED: usize = 2;

fn check_pressure(value: f64) -> Result<(), StepError> {
    if value.is_finite() { Ok(()) } else { Err(StepError::Input { name: "pressure_kpa", value }) }
}
