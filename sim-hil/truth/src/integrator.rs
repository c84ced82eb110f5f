//! Classical fourth-order Runge-Kutta over the whole rig with a fixed step.
//!
//! Explicit, because nothing here is stiff at the step: the fastest volumes are checked against it
//! when the plant is built, and between kinks (choking, corners) the error falls with the fourth
//! power. What moves in jumps (drives, friction, source) is constant or prescribed within a step,
//! so that every step starts smooth.

use super::chamber::{GAS_STATES, GasState, Surroundings};
use super::id::CHANNELS_PER_BOARD;
use super::joint::{AXES, AXIS_STATES, axis_of};
use super::physics::{ChamberPhysics, JointPhysics, RelayRegulator, SupplyLine};
use super::supply::Source;
use super::valve::Conductances;

const TANK: usize = 0;
const MANIFOLD: usize = 1;
const SUPPLY_STATES: usize = 2;
const JOINT_STATES: usize = AXES * AXIS_STATES;

/// Valve and leaks of one channel over a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Openings {
    /// At the start, middle and end of the step.
    pub valve: [Conductances; 3],
    /// Leak from the port to the air, m^3/(s Pa).
    pub leak: f64,
}

/// Everything with a rate of change.
#[derive(Debug, Clone)]
pub struct Dynamics {
    pub chambers: Vec<ChamberPhysics>,
    pub joints: Vec<JointPhysics>,
    pub supply_line: Option<SupplyLine>,
    pub relay: Option<RelayRegulator>,
    pub ambient_k: f64,
}

/// What of the dynamics is idle, found once.
#[derive(Debug, Clone)]
struct Idle {
    joints: bool,
    /// Per channel, whether it is a plain chamber.
    plain: Vec<bool>,
}

/// State vector, its workspace and the step.
#[derive(Debug, Clone)]
pub struct Integrator {
    dynamics: Dynamics,
    idle: Idle,
    step_s: f64,
    y: Vec<f64>,
    trial: Vec<f64>,
    rate: Vec<f64>,
    sum: Vec<f64>,
}

impl Integrator {
    pub fn new(dynamics: Dynamics, step_s: f64, supply_pa: f64, chamber_pa: f64) -> Self {
        let mut y = vec![supply_pa, supply_pa];
        for chamber in &dynamics.chambers {
            y.extend(chamber.at_rest(chamber_pa).to_array());
        }
        y.resize(y.len() + dynamics.joints.len() * JOINT_STATES, 0.0);
        let zeros = vec![0.0; y.len()];
        let idle = Idle {
            joints: !dynamics.joints.iter().any(|joint| joint.free),
            plain: dynamics.chambers.iter().map(ChamberPhysics::is_plain).collect(),
        };
        Self { dynamics, idle, step_s, y, trial: zeros.clone(), rate: zeros.clone(), sum: zeros }
    }

    pub fn dynamics(&self) -> &Dynamics {
        &self.dynamics
    }

    /// Absolute pressure in the tank, Pa (relay regulator only; otherwise not moved).
    pub fn tank_pa(&self) -> f64 {
        self.y[TANK]
    }

    /// Absolute pressure the valves draw from, Pa.
    pub fn manifold_pa(&self, source: &Source) -> f64 {
        self.dynamics.manifold_pa(&self.y, source)
    }

    pub fn gas(&self, channel: usize) -> GasState {
        GasState::from_slice(gas_slice(&self.y, channel))
    }

    /// Bending angles of a board's joint, rad.
    pub fn angles(&self, board: usize) -> [f64; AXES] {
        let at = self.dynamics.joint_at(board);
        [self.y[at], self.y[at + AXIS_STATES]]
    }

    /// Their rates, rad/s.
    pub fn angular_rates(&self, board: usize) -> [f64; AXES] {
        let at = self.dynamics.joint_at(board);
        [self.y[at + 1], self.y[at + AXIS_STATES + 1]]
    }

    /// One step with the given openings (one a channel) and source.
    pub fn step(&mut self, openings: &[Openings], source: &Source) {
        let Self { dynamics, idle, step_s: h, y, trial, rate, sum } = self;
        let h = *h;
        dynamics.rates(idle, y, 0, openings, source, rate);
        sum.copy_from_slice(rate);
        advance(trial, y, rate, 0.5 * h);
        dynamics.rates(idle, trial, 1, openings, source, rate);
        accumulate(sum, rate);
        advance(trial, y, rate, 0.5 * h);
        dynamics.rates(idle, trial, 1, openings, source, rate);
        accumulate(sum, rate);
        advance(trial, y, rate, h);
        dynamics.rates(idle, trial, 2, openings, source, rate);
        for ((y, sum), rate) in y.iter_mut().zip(sum.iter()).zip(rate.iter()) {
            *y += h / 6.0 * (sum + rate);
        }
    }
}

fn advance(out: &mut [f64], y: &[f64], rate: &[f64], h: f64) {
    for ((out, y), rate) in out.iter_mut().zip(y).zip(rate) {
        *out = y + h * rate;
    }
}

fn accumulate(sum: &mut [f64], rate: &[f64]) {
    for (sum, rate) in sum.iter_mut().zip(rate) {
        *sum += 2.0 * rate;
    }
}

/// The gas states of a channel within the vector.
#[inline]
fn gas_slice(y: &[f64], channel: usize) -> &[f64; GAS_STATES] {
    let at = SUPPLY_STATES + channel * GAS_STATES;
    #[expect(clippy::expect_used, reason = "the slice has exactly GAS_STATES elements")]
    y[at..at + GAS_STATES].try_into().expect("GAS_STATES elements")
}

impl Dynamics {
    #[inline]
    fn joint_at(&self, board: usize) -> usize {
        SUPPLY_STATES + self.chambers.len() * GAS_STATES + board * JOINT_STATES
    }

    #[inline]
    fn manifold_pa(&self, y: &[f64], source: &Source) -> f64 {
        if self.supply_line.is_some() {
            y[MANIFOLD]
        } else if self.relay.is_some() {
            y[TANK]
        } else {
            source.pressure_pa
        }
    }

    #[inline]
    fn lengthening_angle(&self, y: &[f64], channel: usize) -> (f64, f64) {
        let board = channel / CHANNELS_PER_BOARD;
        if !self.joints[board].free {
            return (0.0, 0.0);
        }
        let (axis, sign) = axis_of(channel % CHANNELS_PER_BOARD);
        let at = self.joint_at(board) + axis * AXIS_STATES;
        (sign * y[at], sign * y[at + 1])
    }

    /// What surrounds a channel at one of the three instants of a step.
    #[inline]
    pub fn surroundings(
        &self,
        y: &[f64],
        channel: usize,
        instant: usize,
        openings: &Openings,
        source: &Source,
    ) -> Surroundings {
        let (angle, angle_rate) = self.lengthening_angle(y, channel);
        Surroundings {
            supply_pa: self.manifold_pa(y, source),
            supply_k: source.temperature_k,
            valve: openings.valve[instant],
            leak: openings.leak,
            angle,
            angle_rate,
        }
    }

    fn rates(
        &self,
        idle: &Idle,
        y: &[f64],
        instant: usize,
        openings: &[Openings],
        source: &Source,
        out: &mut [f64],
    ) {
        let gas = SUPPLY_STATES..SUPPLY_STATES + self.chambers.len() * GAS_STATES;
        let (states, _) = y[gas.clone()].as_chunks::<GAS_STATES>();
        let (rates, _) = out[gas].as_chunks_mut::<GAS_STATES>();
        let supply_pa = self.manifold_pa(y, source);
        let mut drawn = 0.0;
        let channels = self.chambers.iter().zip(openings).zip(states).zip(rates);
        for (channel, (((chamber, opening), state), rate)) in channels.enumerate() {
            let (angle, angle_rate) =
                if idle.joints { (0.0, 0.0) } else { self.lengthening_angle(y, channel) };
            let surroundings = Surroundings {
                supply_pa,
                supply_k: source.temperature_k,
                valve: opening.valve[instant],
                leak: opening.leak,
                angle,
                angle_rate,
            };
            let state = GasState::from_slice(state);
            let plain = idle.plain[channel] && idle.joints && opening.leak <= 0.0;
            let (own, flows) = if plain {
                chamber.plain_rates(&state, &surroundings)
            } else {
                chamber.rates(&state, &surroundings)
            };
            drawn += flows.fill;
            *rate = own.to_array();
        }
        self.supply_rates(y, drawn, source, out);
        if !idle.joints {
            for board in 0..self.joints.len() {
                self.joint_rates(y, board, out);
            }
        }
    }

    fn supply_rates(&self, y: &[f64], drawn: f64, source: &Source, out: &mut [f64]) {
        let upstream = if self.relay.is_some() { y[TANK] } else { source.pressure_pa };
        let mut from_tank = drawn;
        if let Some(line) = &self.supply_line {
            out[MANIFOLD] = line.rate(upstream, y[MANIFOLD], drawn, self.ambient_k);
            from_tank = line.mass_flow(upstream - y[MANIFOLD]);
        }
        if let Some(relay) = &self.relay {
            out[TANK] = relay.rate(source.refill, from_tank, self.ambient_k);
        }
    }

    fn joint_rates(&self, y: &[f64], board: usize, out: &mut [f64]) {
        let joint = &self.joints[board];
        if !joint.free {
            return;
        }
        for axis in 0..AXES {
            let first = board * CHANNELS_PER_BOARD + 2 * axis;
            let pressure = |channel: usize| match self.chambers.get(channel) {
                Some(chamber) => y[SUPPLY_STATES + channel * GAS_STATES] - chamber.ambient_pa,
                // A pair with one chamber missing bends under the other alone.
                None => 0.0,
            };
            let at = self.joint_at(board) + axis * AXIS_STATES;
            let rates = joint.rates(y[at], y[at + 1], pressure(first) - pressure(first + 1));
            out[at..at + AXIS_STATES].copy_from_slice(&rates);
        }
    }
}

impl Integrator {
    /// What surrounds a channel at the end of the last step.
    pub fn surroundings_now(&self, channel: usize, openings: &Openings, source: &Source) -> Surroundings {
        self.dynamics.surroundings(&self.y, channel, 2, openings, source)
    }
}
