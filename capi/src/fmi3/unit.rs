//! One instance of a unit: the channels of its parameter file, and their time.

use std::path::Path;

use pneudrive_model::export::fmi::{PARAMETERS_FILE, Quantity, SETTINGS_FILE, Settings, referenced};
use pneudrive_model::simulation::CalibratedModel;

use crate::channel::Channel;
use crate::inputs::{Control, Inputs};

/// A communication point may be this part of an internal step off.
const ROUNDING: f64 = 1e-6;

/// An instance.
pub struct Unit {
    step_s: f64,
    chambers: Vec<Chamber>,
    /// Is the start over?
    begun: bool,
    time_s: f64,
}

struct Chamber {
    channel: Channel,
    inputs: Inputs,
    start_kpa: f64,
}

impl Unit {
    /// Reads the resources of a unit, whose description has this token.
    pub fn new(resources: &Path, token: &str) -> Result<Self, String> {
        let path = resources.join(SETTINGS_FILE);
        let wrong = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let text = std::fs::read_to_string(&path).map_err(|e| wrong(&e))?;
        let settings: Settings = toml::from_str(&text).map_err(|e| wrong(&e))?;
        if settings.token != token {
            return Err(wrong(&format_args!("it belongs to the unit {}, not to {token}", settings.token)));
        }
        let model = CalibratedModel::load(&resources.join(PARAMETERS_FILE)).map_err(|e| e.to_string())?;
        let control = if settings.set_point { Control::SetPoint } else { Control::Drive };
        let chamber = |name: &String| -> Result<Chamber, String> {
            let channel =
                Channel::of(&model, name, settings.step_s, control).map_err(|error| error.to_string())?;
            let inputs = *channel.nominal();
            Ok(Chamber { channel, inputs, start_kpa: 0.0 })
        };
        let chambers = settings.channels.iter().map(chamber).collect::<Result<_, _>>()?;
        Ok(Self { step_s: settings.step_s, chambers, begun: false, time_s: 0.0 })
    }

    /// As it was made.
    pub fn reset(&mut self) {
        for chamber in &mut self.chambers {
            chamber.inputs = *chamber.channel.nominal();
            chamber.start_kpa = 0.0;
        }
        (self.begun, self.time_s) = (false, 0.0);
    }

    /// Says when the simulation begins.
    pub fn set_start_time(&mut self, time_s: f64) -> Result<(), String> {
        self.time_s = time_s;
        if time_s.is_finite() { Ok(()) } else { Err(format!("a simulation cannot begin at {time_s} s")) }
    }

    /// Begins at rest.
    pub fn begin(&mut self) -> Result<(), String> {
        for chamber in &mut self.chambers {
            chamber.channel.start(chamber.start_kpa, &chamber.inputs).map_err(|e| e.to_string())?;
        }
        self.begun = true;
        Ok(())
    }

    /// Advances by a whole number of internal steps.
    pub fn advance(&mut self, from_s: f64, length_s: f64) -> Result<(), String> {
        let steps = (length_s / self.step_s).round();
        if !(steps >= 1.0 && (length_s / self.step_s - steps).abs() <= ROUNDING * steps) {
            return Err(format!(
                "a communication step of {length_s} s is not a whole number of internal steps of {} s",
                self.step_s
            ));
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // whole and positive
        for _ in 0..steps as u64 {
            for chamber in &mut self.chambers {
                chamber.channel.step(&chamber.inputs).map_err(|e| e.to_string())?;
            }
        }
        self.time_s = from_s + length_s;
        Ok(())
    }

    /// The value of a variable.
    pub fn get(&mut self, reference: u32) -> Option<f64> {
        if reference == 0 {
            return Some(self.time_s);
        }
        let (channel, quantity) = referenced(reference)?;
        let begun = self.begun;
        let chamber = self.chambers.get_mut(channel)?;
        if !begun {
            // Outputs of the start, as the start values stand.
            chamber.channel.start(chamber.start_kpa, &chamber.inputs).ok()?;
        }
        let (inputs, outputs) = (&chamber.inputs, chamber.channel.outputs());
        Some(match quantity {
            Quantity::SetPoint => inputs.set_point_kpa,
            Quantity::Fill => inputs.fill,
            Quantity::Vent => inputs.vent,
            Quantity::Supply => inputs.supply_kpa,
            Quantity::Volume => inputs.volume_m3,
            Quantity::VolumeRate => inputs.volume_rate_m3_s,
            Quantity::Start => chamber.start_kpa,
            Quantity::Pressure => outputs.pressure_kpa,
            Quantity::Port => outputs.port_kpa,
            Quantity::Reading => outputs.reading_kpa,
            Quantity::Temperature => outputs.temperature_k,
            Quantity::Spool => outputs.fill,
            Quantity::Rate => outputs.rate_kpa_s,
        })
    }

    /// Sets an input, or before the start a parameter.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), String> {
        let none = || format!("value reference {reference} cannot be set to {value}");
        let (channel, quantity) = referenced(reference).ok_or_else(none)?;
        let begun = self.begun;
        let chamber = self.chambers.get_mut(channel).ok_or_else(none)?;
        let inputs = &mut chamber.inputs;
        let place = match quantity {
            Quantity::SetPoint => &mut inputs.set_point_kpa,
            Quantity::Fill => &mut inputs.fill,
            Quantity::Vent => &mut inputs.vent,
            Quantity::Supply => &mut inputs.supply_kpa,
            Quantity::Volume => &mut inputs.volume_m3,
            Quantity::VolumeRate => &mut inputs.volume_rate_m3_s,
            Quantity::Start if !begun => &mut chamber.start_kpa,
            _ => return Err(none()),
        };
        *place = value;
        Ok(())
    }

    /// Everything that it remembers.
    pub fn save(&mut self) -> Vec<f64> {
        let mut state = vec![f64::from(u8::from(self.begun)), self.time_s];
        for chamber in &mut self.chambers {
            let i = &chamber.inputs;
            state.extend([chamber.start_kpa, i.fill, i.vent, i.set_point_kpa, i.supply_kpa]);
            state.extend([i.volume_m3, i.volume_rate_m3_s]);
            let from = state.len();
            state.resize(from + chamber.channel.state_size(), 0.0);
            // It has room for exactly that.
            let _ = chamber.channel.save(&mut state[from..]);
        }
        state
    }

    /// Takes it back; `false` where it is of another unit.
    pub fn restore(&mut self, state: &[f64]) -> bool {
        const INPUTS: usize = 7;
        let size: usize = self.chambers.iter().map(|c| INPUTS + c.channel.state_size()).sum();
        if state.len() != 2 + size {
            return false;
        }
        (self.begun, self.time_s) = (state[0] > 0.5, state[1]);
        let mut rest = &state[2..];
        for chamber in &mut self.chambers {
            let (inputs, after) = rest.split_at(INPUTS);
            let (own, after) = after.split_at(chamber.channel.state_size());
            let i = &mut chamber.inputs;
            [
                chamber.start_kpa,
                i.fill,
                i.vent,
                i.set_point_kpa,
                i.supply_kpa,
                i.volume_m3,
                i.volume_rate_m3_s,
            ] = std::array::from_fn(|k| inputs[k]);
            if chamber.channel.restore(own).is_err() {
                return false;
            }
            rest = after;
        }
        true
    }
}
