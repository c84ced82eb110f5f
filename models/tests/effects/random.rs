//! Random rigs and drives, the same on every machine.

use pneudrive_model::effects::{Domain, DriveInput};
use pneudrive_model::model::{BaseModel, Nonlinear, ValveDrive};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::effects::bench::Bench;

/// Rows of a recording.
const ROWS: usize = 300;

/// What a channel is driven by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrivenBy {
    Spool,
    Separate,
    Board,
    Regulator,
}

impl DrivenBy {
    /// Where an effect makes sense.
    pub fn of(domain: Domain) -> &'static [Self] {
        match domain {
            Domain::Valve => &[Self::Spool, Self::Separate, Self::Board],
            Domain::Regulator => &[Self::Regulator],
            Domain::Both => &[Self::Spool, Self::Separate, Self::Board, Self::Regulator],
        }
    }
}

/// A rig with everything that an effect may look at: a moving joint, a pressure opposite, a sample
/// before, other channels' flow, some rows that repeat each other.
fn rig(seed: u64, driven_by: DrivenBy) -> Bench {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    let start_pa = between(150e3, 350e3);
    let command: Vec<f64> = steps(&mut between, 40, (120e3, 390e3));
    let (fill, vent) = (steps(&mut between, 12, (-0.8, 0.8)), steps(&mut between, 17, (-0.8, 0.8)));
    let mut bench = match driven_by {
        DrivenBy::Regulator => Bench::regulator(between(2.0, 15.0), start_pa, &command),
        DrivenBy::Board => Bench::valve(1.0, start_pa, &fill).in_loop(&command),
        DrivenBy::Spool | DrivenBy::Separate => Bench::valve(1.0, start_pa, &fill),
    };
    let leaks = [between(0.005, 0.05), between(0.005, 0.05)];
    let gains = [between(0.5, 3.0), between(0.5, 3.0)];
    let edges = [between(-0.1, 0.1), between(-0.1, 0.1)];
    let (corner, weight) = (between(0.02, 0.2), between(0.5, 1.5));
    bench.base = match driven_by {
        DrivenBy::Regulator => vec![bench.base[0], bench.base[0] * between(0.8, 1.2)],
        DrivenBy::Separate => {
            let drive = ValveDrive::Separate;
            bench.plant.model = BaseModel::Nonlinear(Nonlinear { drive, ..Nonlinear::default() });
            let open = |drive: &[f64]| drive.iter().map(|u| u.max(0.0)).collect();
            bench.inputs.drive = DriveInput::Separate { fill: open(&fill), vent: open(&vent) };
            [&leaks[..], &gains[..], &edges[..], &[corner, weight]].concat()
        }
        DrivenBy::Spool | DrivenBy::Board => {
            [&leaks[..], &gains[..1], &edges[..], &[corner, weight]].concat()
        }
    };
    let (supply, volume, swing) = (between(450e3, 750e3), between(1e-4, 5e-4), between(0.0, 0.2));
    let inputs = &mut bench.inputs;
    let wave = |hz: f64| move |k: usize| (std::f64::consts::TAU * hz * 0.01 * k as f64).sin();
    let every = |value: &dyn Fn(usize) -> f64| (0..ROWS).map(value).collect();
    let size = |k: usize| volume * (1.0 + swing * wave(0.7)(k));
    inputs.supply_pa = every(&|_| supply);
    inputs.volume_m3 = every(&|k| 0.5 * (size(k) + size(k + 1)));
    inputs.volume_rate_m3_s = every(&|k| (size(k + 1) - size(k)) / 0.01);
    inputs.opposite_pa = every(&|k| 150e3 + 80e3 * wave(0.9)(k));
    inputs.sampled_before_pa = every(&|k| 150e3 + 100e3 * wave(1.1)(k));
    inputs.neighbour_drive = every(&|k| 0.8 * wave(1.3)(k));
    inputs.others_draw = every(&|k| 1e5 * (1.0 + wave(0.5)(k)));
    // Every tenth row and the one after it repeat the row before.
    let measured = |k: usize| if k % 10 < 2 { (k / 10) as f64 } else { k as f64 };
    inputs.measured_pa = every(&|k| start_pa + 1e3 * measured(k));
    bench
}

/// The same in steps of the integration that suit an effect.
pub fn rig_for(id: &str, seed: u64, driven_by: DrivenBy) -> Bench {
    let mut bench = rig(seed, driven_by);
    if id == "line_restriction" {
        // Only steps in which a tube of some millilitres fills are simulated well.
        bench.plant.longest_step_s = 0.0006;
    }
    bench
}

/// Steps of random height, each some rows long.
fn steps(between: &mut impl FnMut(f64, f64) -> f64, rows: usize, (low, high): (f64, f64)) -> Vec<f64> {
    let heights: Vec<f64> = (0..ROWS.div_ceil(rows)).map(|_| between(low, high)).collect();
    (0..ROWS).map(|k| heights[k / rows]).collect()
}
