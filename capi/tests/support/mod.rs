//! Random rigs with models of their channels, recordings of their inputs, and the same inputs step
//! by step.

use std::collections::BTreeMap;

use pneudrive_capi::{Channel, Control, Inputs, REPEATS_AFTER, REPEATS_END, REPEATS_START};
use pneudrive_model::data::{self, ChannelId, Drive, Flags, Joint, Recording, Source};
use pneudrive_model::diagnosis::{ExtendedChannel, ExtendedFile};
use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::effects::{Domain, EffectInfo};
use pneudrive_model::model::{Linear, Model, Nonlinear, ValveDrive};
use pneudrive_model::rig::Rig;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub const STEP_S: f64 = 0.01;

/// What drives the channels of a rig, as a parameter file says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    Spool,
    Separate,
    Board,
    Command,
}

impl Driven {
    pub const ALL: [Self; 4] = [Self::Spool, Self::Separate, Self::Board, Self::Command];

    pub fn name(self) -> &'static str {
        match self {
            Self::Spool => "spool",
            Self::Separate => "separate",
            Self::Board => "board",
            Self::Command => "command",
        }
    }

    /// Does an effect make sense for it?
    pub fn has(self, effect: &EffectInfo) -> bool {
        match effect.domain {
            Domain::Both => true,
            Domain::Valve => self != Self::Command,
            Domain::Regulator => self == Self::Command,
        }
    }
}

pub fn generator(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    rng.random_range(low..high)
}

/// A rig; a regulator's has no board to simulate.
pub fn rig(rng: &mut Pcg64Mcg, driven: Driven) -> Rig {
    let mut text = format!(
        "[supply]\npressure_kpa = {:.1}\n[ambient]\npressure_kpa_abs = {:.2}\ntemperature_k = {:.1}\n\
[chamber]\nradius_m = {:.4}\nlength_m = {:.3}\noffset_m = 0.045\n[valve]\ncritical_ratio = {:.2}\n",
        between(rng, 400.0, 700.0),
        between(rng, 85.0, 103.0),
        between(rng, 280.0, 305.0),
        between(rng, 0.012, 0.03),
        between(rng, 0.1, 0.3),
        between(rng, 0.1, 0.5),
    );
    if driven != Driven::Command {
        text += &format!(
            "[controller]\nrate_hz = 1000.0\nkp = {:.1}\nkd = {:.1}\nsaturation = 400.0\nfilter = {:.2}\n\
[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.841645\n",
            between(rng, 3.0, 12.0),
            between(rng, 0.0, 20.0),
            between(rng, 0.0, 0.8),
        );
    }
    Rig::parse("rig.toml", &text).unwrap()
}

/// Names and values of the base model's parameters.
pub fn base(rng: &mut Pcg64Mcg, driven: Driven) -> BTreeMap<String, f64> {
    let valve = |drive| Nonlinear { drive, ..Nonlinear::default() }.parameters();
    let parameters = match driven {
        Driven::Command => Linear::default().parameters(),
        Driven::Separate => valve(ValveDrive::Separate),
        Driven::Spool | Driven::Board => valve(ValveDrive::Spool),
    };
    let mut value = |name: &str| match name {
        "leak_in" | "leak_out" => between(rng, 0.0, 0.02),
        "gain" | "gain_in" | "gain_out" => between(rng, 0.5, 3.0),
        "threshold_in" => between(rng, 0.0, 0.1),
        "threshold_out" if driven == Driven::Separate => between(rng, 0.0, 0.1),
        "threshold_out" => between(rng, -0.1, 0.0),
        "corner" => between(rng, 0.005, 0.1),
        "volume_weight" => between(rng, 0.8, 1.2),
        "alpha" | "beta" => between(rng, 2.0, 20.0),
        other => panic!("a value for {other}"),
    };
    parameters.iter().map(|p| (p.name.clone(), value(&p.name))).collect()
}

/// Values of an effect's parameters, from absent to far from it.
pub fn effect(rng: &mut Pcg64Mcg, info: &EffectInfo) -> BTreeMap<String, f64> {
    let mut one = |p: &pneudrive_model::effects::EffectParameter| {
        let bound = if rng.random_bool(0.5) { p.lower } else { p.upper };
        (p.name.to_owned(), p.null + between(rng, 0.02, 0.3) * (bound - p.null))
    };
    info.parameters.iter().map(&mut one).collect()
}

/// A model of `channels` channels of one board with the same effects, each with values of its own.
pub fn extended(rng: &mut Pcg64Mcg, driven: Driven, channels: u8, effects: &[&str]) -> ExtendedFile {
    let rig = rig(rng, driven);
    let model = if driven == Driven::Command { "linear" } else { "nonlinear" };
    let mut one = |channel: u8| {
        let of = |id: &str| CATALOGUE.iter().find(|info| info.id == id).unwrap();
        let stored = ExtendedChannel {
            drive: driven.name().to_owned(),
            noise_kpa: 0.3,
            command_range_kpa: 300.0,
            parameters: base(rng, driven),
            effects: effects.iter().map(|id| ((*id).to_owned(), effect(rng, of(id)))).collect(),
            correction: None,
            band: None,
        };
        (ChannelId { board: 0, channel }.to_string(), stored)
    };
    ExtendedFile {
        schema: "pneudrive-extended/1".to_owned(),
        model: model.to_owned(),
        provenance: None,
        channels: (0..channels).map(&mut one).collect(),
        rig,
    }
}

/// Levels that are held for 20 to 300 ms.
fn levels(rng: &mut Pcg64Mcg, rows: usize, low: f64, high: f64) -> Vec<f32> {
    let mut values = Vec::with_capacity(rows);
    while values.len() < rows {
        let (hold, level) = (rng.random_range(2..30), between(rng, low, high));
        values.extend(std::iter::repeat_n(level as f32, hold));
    }
    values.truncate(rows);
    values
}

/// A recording of inputs; `measured` adds pressures that repeat themselves now and then, `jointed`
/// the angles of a moving joint.
pub fn recording(
    rng: &mut Pcg64Mcg,
    (driven, channels, rows): (Driven, u8, usize),
    measured: bool,
    jointed: bool,
) -> Recording {
    let mut one = |channel: u8| {
        let command = levels(rng, rows, 20.0, 280.0);
        let drive = match driven {
            Driven::Spool => Some(Drive::Spool(levels(rng, rows, -0.6, 0.6))),
            Driven::Separate => {
                let (fill, vent) = (levels(rng, rows, 0.0, 0.5), levels(rng, rows, 0.0, 0.5));
                Some(Drive::Separate { fill, vent })
            }
            Driven::Board | Driven::Command => None,
        };
        let mut last = 50.0;
        let mut pressure = |_| {
            if rng.random_bool(0.7) {
                last += 1.0 + rng.random_range(0.0..1.0_f32);
            }
            last
        };
        data::Channel {
            id: ChannelId { board: 0, channel },
            command_kpa: Some(command),
            pressure_kpa: measured.then(|| (0..rows).map(&mut pressure).collect()),
            drive,
            flags: vec![Flags::NONE; rows],
        }
    };
    let channels = (0..channels).map(&mut one).collect();
    let angle = |from: f64| (0..rows).map(|k| (0.8 * (0.02 * k as f64 + from).sin()) as f32).collect();
    let joint = Joint { board: 0, qu_rad: Some(angle(0.0)), qv_rad: Some(angle(1.0)) };
    Recording {
        source: Source { file: "inputs.csv".to_owned(), sha256: String::new(), bytes: 0 },
        time_s: (0..rows).map(|k| STEP_S * k as f64).collect(),
        line: (2..).take(rows).collect(),
        breaks: Vec::new(),
        period_s: STEP_S,
        channels,
        joints: if jointed { vec![joint] } else { Vec::new() },
        board_supplies: Vec::new(),
        supply_kpa: Some((0..rows).map(|k| (520.0 + 20.0 * (0.05 * k as f64).sin()) as f32).collect()),
    }
}

/// What a channel knows of its neighbours, row by row.
#[derive(Debug, Clone, Default)]
pub struct Neighbours {
    pub opposite_kpa: Vec<f64>,
    pub sampled_before_kpa: Vec<f64>,
    pub others_draw: Vec<f64>,
}

/// A channel stepped through the rows of a recording: what it reports at each row, and what it
/// draws in each interval.
pub fn stepped(
    channel: &mut Channel,
    (rig, recording): (&Rig, &Recording),
    of: &data::Channel,
    supply: impl Fn(&[f32], usize) -> f64,
    neighbours: &Neighbours,
) -> (Vec<f64>, Vec<f64>) {
    let inputs = |row: usize| row_inputs(channel.nominal(), (rig, recording), of, &supply, neighbours, row);
    let all: Vec<Inputs> = (0..recording.rows()).map(inputs).collect();
    let start = of.pressure_kpa.as_ref().map_or(0.0, |p| f64::from(p[0]));
    let mut readings = vec![channel.start(start, &all[0]).unwrap().reading_kpa];
    let mut draws = Vec::new();
    for inputs in &all {
        let outputs = channel.step(inputs).unwrap();
        readings.push(outputs.reading_kpa);
        draws.push(outputs.draw);
    }
    readings.pop();
    (readings, draws)
}

pub fn row_inputs(
    nominal: &Inputs,
    (rig, recording): (&Rig, &Recording),
    of: &data::Channel,
    supply: &impl Fn(&[f32], usize) -> f64,
    neighbours: &Neighbours,
    row: usize,
) -> Inputs {
    let last = recording.rows() - 1;
    let pair = |series: &[f64]| match series.get(row) {
        Some(here) => [*here, series[(row + 1).min(last)]],
        None => [f64::NAN; 2],
    };
    let repeats = |row: usize, bit: u32| match &of.pressure_kpa {
        Some(p) if row > 0 && row <= last && p[row].total_cmp(&p[row - 1]).is_eq() => bit,
        _ => 0,
    };
    let (fill, vent) = match &of.drive {
        Some(Drive::Spool(u)) => (f64::from(u[row]), 0.0),
        Some(Drive::Separate { fill, vent }) => (f64::from(fill[row]), f64::from(vent[row])),
        None => (0.0, 0.0),
    };
    let mut inputs = Inputs {
        fill,
        vent,
        set_point_kpa: of.command_kpa.as_ref().map_or(0.0, |c| f64::from(c[row])),
        supply_kpa: supply(recording.supply_kpa.as_ref().unwrap(), row),
        opposite_kpa: pair(&neighbours.opposite_kpa),
        sampled_before_kpa: pair(&neighbours.sampled_before_kpa),
        others_draw: neighbours.others_draw.get(row).copied().unwrap_or(0.0),
        repeats: repeats(row, REPEATS_START)
            | repeats(row + 1, REPEATS_END)
            | repeats(row + 2, REPEATS_AFTER),
        ..*nominal
    };
    if let Some((angle, sign)) = recording.joint_angle(of.id) {
        let chamber = rig.chamber.as_ref().unwrap();
        let volume = |row: usize| {
            chamber.rest_volume_m3() + sign * chamber.volume_per_rad_m3() * f64::from(angle[row])
        };
        let (here, there) = (volume(row), volume((row + 1).min(last)));
        inputs.volume_m3 = 0.5 * (here + there);
        inputs.volume_rate_m3_s = (there - here) / STEP_S;
    }
    inputs
}

/// A channel of a model for steps of [`STEP_S`].
pub fn channel(model: &pneudrive_model::simulation::CalibratedModel, id: ChannelId) -> Channel {
    Channel::of(model, &id.to_string(), STEP_S, Control::AsCalibrated).unwrap()
}
