//! A channel with the parameters of a fit.

use pneudrive_model::data::ChannelId;
use pneudrive_model::experiment::{Setup, subject};
use pneudrive_model::model::column;
use pneudrive_model::rollout::RowStepper;
use pneudrive_model::store::ParameterFile;

use crate::engine::{Engine, check_loop};
use crate::error::CreateError;
use crate::inputs::{Control, Inputs};
use crate::outputs::Outputs;

const PA_PER_KPA: f64 = 1e3;

/// The engine: Runge-Kutta steps as many as the fit found to be needed.
pub struct FittedEngine {
    stepper: Box<dyn RowStepper>,
    row: [f64; column::COUNT],
    values: usize,
    pressure_kpa: f64,
    setup: Setup,
    step_s: f64,
    ambient_pa: f64,
    temperature_k: f64,
}

impl FittedEngine {
    /// Sets up a channel; `name` is the file's, for messages.
    pub fn new(
        (name, file): (&str, &ParameterFile),
        id: ChannelId,
        step_s: f64,
        control: Control,
        nominal: &Inputs,
    ) -> Result<Self, CreateError> {
        let stored = file.channel(name, id)?;
        let mut setup = stored.setup;
        let regulator = setup.model.is_regulator();
        match control {
            Control::Drive if regulator => return Err(CreateError::Regulator { channel: id }),
            Control::SetPoint if !regulator => setup.controller = true,
            Control::Drive => setup.controller = false,
            Control::AsCalibrated | Control::SetPoint => {}
        }
        let rig = file.rig.at(id);
        let subject = subject(setup, &rig, file.flow_form())?;
        if let Some(controller) = rig.controller.as_ref().filter(|_| setup.controller) {
            check_loop(step_s, controller.rate_hz)?;
        }
        let parameters = file.values(name, id, &subject)?;
        let ambient = rig.ambient_or_standard();
        let ambient_pa = ambient.pressure_kpa_abs * PA_PER_KPA;
        let row = row(step_s, ambient_pa, setup, nominal);
        let mut stepper = subject.stepper(&parameters, stored.substeps, &row, ambient_pa);
        let mut values = 0;
        stepper.values(&mut |_| values += 1);
        let temperature_k = ambient.temperature_k;
        Ok(Self { stepper, row, values, pressure_kpa: 0.0, setup, step_s, ambient_pa, temperature_k })
    }

    fn kpa(&self, pa: f64) -> f64 {
        (pa - self.ambient_pa) / PA_PER_KPA
    }

    fn outputs(&mut self) -> Outputs {
        let (mut first, mut last) = (None, f64::NAN);
        self.stepper.values(&mut |value| {
            first.get_or_insert(*value);
            last = *value;
        });
        let pressure_kpa = self.kpa(first.unwrap_or(f64::NAN));
        let reading_pa = self.stepper.reading_pa(&self.row);
        let [fill, vent] = match self.setup {
            Setup { model, .. } if model.is_regulator() => [f64::NAN; 2],
            Setup { controller: true, .. } => [last, -last],
            _ => [self.row[column::FILL], self.row[column::VENT]],
        };
        let separate = self.setup.drive == Some(pneudrive_model::experiment::DriveKind::Separate);
        Outputs {
            pressure_kpa,
            port_kpa: pressure_kpa,
            reading_kpa: self.kpa(reading_pa),
            temperature_k: self.temperature_k,
            fill,
            vent,
            drive: if separate { fill - vent } else { fill },
            draw: f64::NAN,
            ..Outputs::default()
        }
    }
}

/// A step's inputs as the models take them.
fn row(step_s: f64, ambient_pa: f64, setup: Setup, inputs: &Inputs) -> [f64; column::COUNT] {
    let mut row = [0.0; column::COUNT];
    let separate = setup.drive == Some(pneudrive_model::experiment::DriveKind::Separate);
    row[column::INTERVAL_S] = step_s;
    row[column::FILL] = inputs.fill;
    row[column::VENT] = if separate { inputs.vent } else { -inputs.fill };
    row[column::COMMAND_PA] = ambient_pa + PA_PER_KPA * inputs.set_point_kpa;
    row[column::SUPPLY_PA] = ambient_pa + PA_PER_KPA * inputs.supply_kpa;
    row[column::INVERSE_VOLUME_PER_M3] = inputs.volume_m3.recip();
    row[column::VOLUME_RATE_M3_S] = inputs.volume_rate_m3_s;
    row
}

impl Engine for FittedEngine {
    fn start(&mut self, kpa: f64, inputs: &Inputs) -> Outputs {
        self.pressure_kpa = kpa;
        self.row = row(self.step_s, self.ambient_pa, self.setup, inputs);
        self.stepper.start(&self.row, self.ambient_pa + PA_PER_KPA * kpa);
        self.outputs()
    }

    fn step(&mut self, step: u64, inputs: &Inputs) -> Outputs {
        self.row = row(self.step_s, self.ambient_pa, self.setup, inputs);
        if step == 0 {
            // What was commanded before is not known: what is commanded first.
            self.stepper.start(&self.row, self.ambient_pa + PA_PER_KPA * self.pressure_kpa);
        }
        self.stepper.advance(&self.row);
        self.outputs()
    }

    fn set_pressure(&mut self, kpa: f64) {
        self.pressure_kpa = kpa;
        let mut pressure = Some(self.ambient_pa + PA_PER_KPA * kpa);
        self.stepper.values(&mut |value| {
            if let Some(pressure) = pressure.take() {
                *value = pressure;
            }
        });
    }

    fn size(&self) -> usize {
        self.values + 1
    }

    fn save(&mut self, into: &mut dyn FnMut(f64)) {
        into(self.pressure_kpa);
        self.stepper.values(&mut |value| into(*value));
    }

    fn restore(&mut self, from: &mut dyn FnMut() -> f64) {
        self.pressure_kpa = from();
        self.stepper.values(&mut |value| *value = from());
    }
}
