//! Parameters, spread and effects brought together.

use super::super::error::{EffectError, PlantError};
use super::super::flow::{ANR_DENSITY_KG_PER_M3, FlowFunction};
use super::super::id::{CHANNELS_PER_BOARD, ChannelId};
use super::super::noise::{Purpose, normal, stream};
use super::super::parameters::PlantParameters;
use super::super::physics::{
    ChannelPhysics, GAS_CONSTANT, GasPhysics, JointPhysics, SideVolume, SupplyPhysics,
};
use super::definition::Apply;
use super::effect::{Effect, Scope};

/// A rig in SI numbers.
#[derive(Debug, Clone)]
pub struct Resolved {
    pub channels: Vec<ChannelPhysics>,
    pub joints: Vec<JointPhysics>,
    pub supply: SupplyPhysics,
}

/// Applies the spread, then the effects.
pub fn resolve(parameters: &PlantParameters, effects: &[Effect], seed: u64) -> Result<Resolved, PlantError> {
    let boards = parameters.channels.div_ceil(CHANNELS_PER_BOARD);
    let mut resolved = Resolved {
        channels: (0..parameters.channels).map(|place| spread(parameters, seed, place)).collect(),
        joints: vec![parameters.joint_physics(); boards],
        supply: parameters.supply_physics(),
    };
    for (k, effect) in effects.iter().enumerate() {
        refuse_overlap(effect, &effects[..k])?;
        resolved.apply(parameters, effect)?;
    }
    for channel in &resolved.channels {
        let flow = &channel.chamber.flow;
        FlowFunction::new(flow.critical_ratio(), flow.exponent(), flow.laminar_ratio())?;
    }
    Ok(resolved)
}

/// Channel-to-channel spread: conductance and volume by a lognormal factor, edges and leakage in
/// proportion.
fn spread(parameters: &PlantParameters, seed: u64, place: usize) -> ChannelPhysics {
    let mut channel = parameters.channel_physics();
    let s = parameters.nuisances.spread;
    if s > 0.0 {
        let mut rng = stream(seed, Purpose::Spread, place);
        let mut factor = |scale: f64| (scale * s * normal(&mut rng)).exp();
        channel.valve.conductance *= factor(1.0);
        let volume = factor(1.0);
        channel.chamber.volume_factor *= volume;
        if let GasPhysics::Balance { wall_w_per_k } = &mut channel.chamber.gas {
            *wall_w_per_k *= volume;
        }
        channel.valve.fill_edge *= factor(2.0);
        channel.valve.vent_edge *= factor(2.0);
        channel.valve.leakage *= factor(4.0);
    }
    parameters.nuisances.background.draw(&parameters.valve, seed, place, &mut channel);
    channel
}

/// The same effect twice in one place would hide one of them.
fn refuse_overlap(effect: &Effect, earlier: &[Effect]) -> Result<(), EffectError> {
    let overlaps = |other: &Effect| match (other.scope(), effect.scope()) {
        (Scope::Channel(a), Scope::Channel(b)) => a == b,
        (Scope::Channel(a), Scope::Board(b)) | (Scope::Board(b), Scope::Channel(a)) => a.board == b,
        (Scope::Board(a), Scope::Board(b)) => a == b,
        (Scope::Rig, _) | (_, Scope::Rig) => true,
    };
    match earlier.iter().find(|other| other.id() == effect.id() && overlaps(other)) {
        Some(_) => Err(EffectError::Twice { id: effect.id(), place: effect.scope().to_string() }),
        None => Ok(()),
    }
}

impl Resolved {
    fn apply(&mut self, parameters: &PlantParameters, effect: &Effect) -> Result<(), PlantError> {
        let here = |place: usize| ChannelId::from_index(place).is_some_and(|id| effect.scope().covers(id));
        if !(0..self.channels.len()).any(here) {
            return Err(EffectError::NoSuchPlace {
                id: effect.id(),
                scope: effect.scope().to_string(),
                channels: self.channels.len(),
            }
            .into());
        }
        if effect.is_null() {
            return Ok(());
        }
        match effect.definition().apply {
            Apply::Channel(apply) => {
                for (_, channel) in self.channels.iter_mut().enumerate().filter(|(place, _)| here(*place)) {
                    apply(effect.values(), parameters, channel);
                }
            }
            Apply::Joint(apply) => {
                let on_board = |board: usize| here(board * CHANNELS_PER_BOARD);
                for (_, joint) in self.joints.iter_mut().enumerate().filter(|(board, _)| on_board(*board)) {
                    apply(effect.values(), parameters, joint);
                }
                // The effect may move more than the parameters' own joint: the chambers must keep a
                // length.
                let mut moved = parameters.clone();
                moved.joint.free = true;
                moved.joint.angle_rad_per_mpa = effect.values()[0];
                moved.validate()?;
            }
            Apply::Supply(apply) => apply(effect.values(), parameters, &mut self.supply),
        }
        Ok(())
    }

    /// Refuses volumes that fill or empty faster than the step can follow.
    ///
    /// The rate of a volume is bounded by the steepest part of the flow function (the laminar
    /// segment) of every orifice that ends in it. Runge-Kutta of order four is stable to 2.78
    /// step/time constant; we ask for one step or more.
    pub fn check_step(&self, step_s: f64) -> Result<(), PlantError> {
        for (place, channel) in self.channels.iter().enumerate() {
            let Some(id) = ChannelId::from_index(place) else { continue };
            let chamber = &channel.chamber;
            let slope = chamber.flow.steepest() * ANR_DENSITY_KG_PER_M3;
            // An edge opens to its rated conductance and a little more with a shifted centre or a
            // higher gain.
            let valve =
                channel.valve.conductance * channel.valve.gain * (1.0 + channel.valve.centre.abs()) * 1.1;
            let rate = |volume: f64, conductance: f64| {
                1.4 * GAS_CONSTANT * chamber.ambient_k / volume * conductance * slope
            };
            let check = |what, enlarge, rate: f64| {
                if rate * step_s <= 1.0 {
                    return Ok(());
                }
                Err(PlantError::TooStiff {
                    what,
                    channel: id,
                    time_constant_us: 1e6 / rate,
                    step_us: 1e6 * step_s,
                    required_us: 1e6 * step_s,
                    enlarge,
                })
            };
            let with = |side: SideVolume| rate(side.volume_m3, side.conductance + valve);
            if let Some(line) = chamber.line {
                check("the tube", "the volume or the restriction of line_restriction", with(line))?;
            }
            if let Some(muffler) = chamber.muffler {
                check("the muffler", "the volume or the restriction of vent_restriction", with(muffler))?;
            }
            let volume = chamber.volume_factor * chamber.area_m2 * chamber.length_m;
            let tube = chamber.line.map_or(valve, |line| line.conductance);
            if let GasPhysics::Balance { wall_w_per_k } = chamber.gas {
                // The thinnest gas follows the wall fastest: at ambient pressure.
                let heat_capacity = chamber.ambient_pa * volume / (0.4 * chamber.ambient_k);
                check("the gas temperature", "the wall's time constant", wall_w_per_k / heat_capacity)?;
            }
            check("the chamber", "chamber.radius_m or chamber.length_m", rate(volume, tube.max(valve)))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Nuisances;

    /// The wall follows the spread of the volume, so that every channel has the time constant that
    /// was asked for.
    #[test]
    fn the_time_constant_of_the_gas_is_that_of_every_channel() {
        let nuisances = Nuisances { spread: 0.05, ..Nuisances::none() };
        let parameters = PlantParameters { nuisances, ..PlantParameters::default() };
        let effect = Effect::of_size("heat_exchange", 0.5, Scope::Rig).unwrap();
        let resolved = resolve(&parameters, &[effect], 7).unwrap();
        let wanted = parameters.wall_conductance(0.5);
        for channel in &resolved.channels {
            let factor = channel.chamber.volume_factor;
            assert!((factor - 1.0).abs() > 1e-4, "the volumes differ: {factor}");
            let GasPhysics::Balance { wall_w_per_k } = channel.chamber.gas else {
                panic!("the gas has a balance: {:?}", channel.chamber.gas)
            };
            assert!((wall_w_per_k / factor - wanted).abs() < 1e-12 * wanted, "{wall_w_per_k} at {factor}");
        }
    }
}
