//! A channel on a bench: everything about it is set by the test, nothing is measured.
//!
//! The only file of these tests that knows how a channel with effects is simulated.

use pneudrive_model::board::Law;
use pneudrive_model::data::ChannelId;
use pneudrive_model::diagnosis::{Block, ChannelData, Extended, Role};
use pneudrive_model::effects::catalogue::{CATALOGUE, index_of};
use pneudrive_model::effects::{BoardLoop, ChannelInputs, DriveInput, EffectInfo, Plant, Series};
use pneudrive_model::model::{ATMOSPHERE_PA, BaseModel, Linear, Nonlinear, Scale, column, psi_max};
use pneudrive_model::rollout::{Chamber, Rows, Steps, System};

/// Effects at work, each with the values of its parameters.
pub type Installed<'a> = &'a [(&'a str, &'a [f64])];

/// Critical ratio of the bench's ports.
pub const CRITICAL_RATIO: f64 = 0.3;

/// One row of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// What the sensor reports at the row's time, absolute, Pa.
    pub reading_pa: f64,
    /// Mean drive over the interval that starts at the row, -1 to 1.
    pub drive: f64,
    /// Mean flow drawn from the supply over that interval: effective area by flow pressure, mm^2
    /// Pa.
    pub draw: f64,
}

/// Derivatives of every row's reading (Pa) by one parameter, by its logarithm where it is fitted
/// so.
#[derive(Debug, Clone)]
pub struct Derivative {
    /// Name of the parameter; an effect's begins with the effect's id.
    pub parameter: String,
    /// As the simulation gives them.
    pub exact: Vec<f64>,
    /// Differences to a slightly smaller value.
    pub before: Vec<f64>,
    /// Differences to a slightly larger value.
    pub behind: Vec<f64>,
}

/// A channel and what it is given.
#[derive(Debug, Clone)]
pub struct Bench {
    pub plant: Plant,
    pub base: Vec<f64>,
    pub inputs: ChannelInputs,
}

impl Bench {
    /// A tight valve of `gain` mm^2 at full drive without rounded corners, in front of a rigid
    /// chamber of 0.36 l; supply at 650 kPa, all absolute. The drive of each row holds for 10 ms,
    /// which is one step of the integration.
    pub fn valve(gain: f64, start_pa: f64, drive: &[f64]) -> Self {
        let inputs = inputs(drive.len(), start_pa, DriveInput::Spool(drive.into()));
        let base = vec![0.0, 0.0, gain, 0.0, 0.0, 1e-9, 1.0];
        Self { plant: plant(BaseModel::Nonlinear(Nonlinear::default())), base, inputs }
    }

    /// A regulator with dp/dt = alpha (command - p), gauge, that starts at a pressure in Pa
    /// absolute.
    pub fn regulator(alpha: f64, start_pa: f64, command_pa: &[f64]) -> Self {
        let mut inputs = inputs(command_pa.len(), start_pa, DriveInput::Command);
        inputs.command_pa = command_pa.into();
        Self { plant: plant(BaseModel::Linear(Linear::default())), base: vec![alpha, alpha], inputs }
    }

    /// With the valve behind the controller of a board, which follows commands in Pa absolute.
    pub fn in_loop(mut self, command_pa: &[f64]) -> Self {
        self.inputs.drive = DriveInput::Controlled;
        self.inputs.command_pa = command_pa.into();
        self.plant.board = Some(BoardLoop {
            rate_hz: 400.0,
            law: Law { gain: 3e-5, damping: 0.0, weight: 0.5 },
            lowest_pa: -86e3,
            highest_pa: 775e3,
            rounding_pa: 100.0,
            loops_per_step: 1,
            noise_draw: 0,
        });
        self
    }

    pub fn rows(&self) -> usize {
        self.inputs.rows()
    }

    /// The same value in every row.
    pub fn every(&self, value: f64) -> Series {
        vec![value; self.rows()].into()
    }

    /// Rate of the pressure per mm^2, Pa of flow pressure and inverse volume, m^3/(mm^2 s).
    pub fn conductance(&self) -> f64 {
        self.plant.model.valve().expect("a valve").conductance()
    }

    /// Rate of the pressure per mm^2 of a choked port and Pa in front of it, 1/(mm^2 s):
    /// `gamma sqrt(2 R T) psi_max / V`.
    pub fn choked_rate(&self) -> f64 {
        self.conductance() / self.inputs.volume_m3[0] * psi_max()
    }

    /// Simulates all rows.
    pub fn run(&self, effects: Installed<'_>) -> Vec<Sample> {
        self.trace(&self.model(effects))
    }

    /// Absolute pressures in Pa as a fit simulates the base model from recorded drives, with this
    /// many Runge-Kutta steps a row.
    pub fn rollout(&self, substeps: usize) -> Vec<f64> {
        let system: Box<dyn System> = match self.plant.model {
            BaseModel::Nonlinear(model) => Box::new(Chamber::new(model)),
            BaseModel::Linear(model) => Box::new(Chamber::new(model)),
        };
        let mut table = vec![0.0; self.rows() * column::COUNT];
        for (k, row) in table.chunks_exact_mut(column::COUNT).enumerate() {
            row[column::INTERVAL_S] = self.inputs.interval_s[k];
            (row[column::FILL], row[column::VENT]) = match &self.inputs.drive {
                DriveInput::Spool(u) => (u[k], -u[k]),
                DriveInput::Separate { fill, vent } => (fill[k], vent[k]),
                DriveInput::Controlled | DriveInput::Command => (0.0, 0.0),
            };
            row[column::COMMAND_PA] = self.inputs.command_pa[k];
            row[column::SUPPLY_PA] = self.inputs.supply_pa[k];
            row[column::INVERSE_VOLUME_PER_M3] = 1.0 / self.inputs.volume_m3[k];
            row[column::VOLUME_RATE_M3_S] = self.inputs.volume_rate_m3_s[k];
        }
        let rows = Rows { inputs: &table, width: column::COUNT };
        let mut pressures = vec![0.0; self.rows()];
        let (start_pa, steps) = (self.inputs.measured_pa[0], Steps { ticks: 1, substeps });
        system.simulate(&self.base, rows, start_pa, steps, &mut pressures);
        pressures
    }

    /// Derivatives by all parameters, base and effects.
    pub fn derivatives(&self, effects: Installed<'_>) -> Vec<Derivative> {
        let model = self.model(effects);
        let data = self.data();
        let parameters = model.parameters(&self.plant);
        let all: Vec<usize> = (0..parameters.len()).collect();
        let (_, matrix) = data.sensitivities(&model, &all);
        let here = self.trace(&model);
        // Small enough to stay on one side of nearly every kink, large enough for rounding.
        let step = |k: usize| match parameters[k].scale {
            Scale::Logarithmic => 1e-6,
            Scale::Linear => 1e-6 * model.values[k].abs().max(1e-3),
        };
        let difference = |k: usize, sign: f64| -> Vec<f64> {
            let mut moved = model.clone();
            match parameters[k].scale {
                Scale::Logarithmic => moved.values[k] *= (sign * step(k)).exp(),
                Scale::Linear => moved.values[k] += sign * step(k),
            }
            let pairs = self.trace(&moved).into_iter().zip(&here);
            pairs.map(|(there, here)| (there.reading_pa - here.reading_pa) / (sign * step(k))).collect()
        };
        let exact = |k: usize| matrix.iter().skip(k).step_by(all.len()).map(|v| 1e3 * v).collect();
        let of = |k: usize| Derivative {
            parameter: parameters[k].name.clone(),
            exact: exact(k),
            before: difference(k, -1.0),
            behind: difference(k, 1.0),
        };
        all.iter().map(|&k| of(k)).collect()
    }

    fn trace(&self, model: &Extended) -> Vec<Sample> {
        let row = |[reading_kpa, drive, draw]: [f64; 3]| Sample {
            reading_pa: 1e3 * reading_kpa + self.inputs.ambient_pa,
            drive,
            draw,
        };
        self.data().trace(model).into_iter().map(row).collect()
    }

    fn model(&self, effects: Installed<'_>) -> Extended {
        let base = Extended::base(self.base.clone());
        effects.iter().fold(base, |model, (id, values)| model.with(&self.plant, number(id), values))
    }

    fn data(&self) -> ChannelData {
        let rows = self.rows();
        let number = |row: usize| u32::try_from(row).expect("few rows");
        ChannelData {
            id: ChannelId { board: 0, channel: 0 },
            plant: self.plant.clone(),
            inputs: self.inputs.clone(),
            blocks: vec![Block { start: 0, compared: 0, end: rows, role: Role::Fit }],
            rows: (0..rows).map(number).collect(),
            spans: std::iter::once(0..rows).collect(),
            measured_kpa: self.every(0.0),
            noise_kpa: 0.3,
        }
    }
}

/// The catalogue.
pub fn catalogue() -> &'static [&'static EffectInfo] {
    CATALOGUE
}

fn number(id: &str) -> usize {
    index_of(id).unwrap_or_else(|| panic!("the catalogue has no {id}"))
}

fn plant(model: BaseModel) -> Plant {
    Plant { model, board: None, longest_step_s: 0.01, command_range_pa: 300e3 }
}

fn inputs(rows: usize, start_pa: f64, drive: DriveInput) -> ChannelInputs {
    let every = |value: f64| -> Series { vec![value; rows].into() };
    ChannelInputs {
        time_s: (0..rows).map(|k| 0.01 * k as f64).collect(),
        interval_s: every(0.01),
        duration_s: 0.01 * (rows.max(1) - 1) as f64,
        starts: [0].into(),
        anchors: [].into(),
        drive,
        command_pa: every(start_pa),
        supply_pa: every(650e3),
        volume_m3: every(3.6e-4),
        volume_rate_m3_s: every(0.0),
        measured_pa: every(start_pa),
        usable: vec![true; rows].into(),
        opposite_pa: Series::default(),
        sampled_before_pa: Series::default(),
        neighbour_drive: Series::default(),
        others_draw: every(0.0),
        noise_pa: 100.0,
        ambient_pa: ATMOSPHERE_PA,
    }
}
