//! One file per effect, and their list.

use super::{
    ChannelInputs, EffectInfo, Facing, Hook, Memory, Question, RegulatorLaw, Step, Stretch, Structure,
};
use crate::model::{Areas, ValveLaw};
use crate::numeric::Scalar;

/// Declares the modules, the list and one type that is any of them. Effects of a model are called
/// in the order of the list, which for those between drive and flow is the order of the hardware.
macro_rules! catalogue {
    ($($module:ident :: $name:ident,)*) => {
        $(mod $module;)*

        /// All effects.
        pub static CATALOGUE: &[&EffectInfo] = &[$(&$module::INFO),*];

        /// Any effect of the catalogue, at work.
        #[derive(Debug, Clone)]
        #[allow(missing_docs, clippy::large_enum_variant)]
        pub enum AnyEffect<S: Scalar> {
            $($name($module::$name<S>)),*
        }

        // What its effect's `Hook` does, without a call for what that leaves alone. In place: a
        // value is large with derivatives, and most effects leave it as it is at every step.
        impl<S: Scalar> AnyEffect<S> {
            /// Installs number `index` of the [`CATALOGUE`] with the values of its parameters;
            /// `None` beyond its end.
            #[must_use]
            pub fn install(index: usize, values: &[S]) -> Option<Self> {
                let mut number = 0;
                $(
                    if number == index {
                        return Some(Self::$name($module::$name::new(values)));
                    }
                    number += 1;
                )*
                let _ = number;
                None
            }

            /// See [`Hook::reset`].
            pub fn reset(&mut self) {
                match self { $(Self::$name(e) => e.reset()),* }
            }

            /// See [`Hook::memory`].
            pub fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
                match self { $(Self::$name(e) => e.memory(visit)),* }
            }

            /// See [`Hook::structure`].
            pub fn structure(&self, structure: &mut Structure<S>) {
                match self { $(Self::$name(e) => e.structure(structure)),* }
            }

            /// See [`Hook::drive`].
            #[inline(always)]
            pub fn drive(&mut self, step: &Step<'_>, valve: usize, drive: &mut S) {
                match self { $(Self::$name(e) => *drive = e.drive(step, valve, *drive)),* }
            }

            /// See [`Hook::valve`].
            #[inline(always)]
            pub fn valve(&mut self, step: &Step<'_>, law: &mut ValveLaw<S>) {
                match self { $(Self::$name(e) => e.valve(step, law)),* }
            }

            /// See [`Hook::regulator`].
            #[inline(always)]
            pub fn regulator(&mut self, step: &Step<'_>, law: &mut RegulatorLaw<S>) {
                match self { $(Self::$name(e) => e.regulator(step, law)),* }
            }

            /// See [`Hook::areas`].
            #[inline(always)]
            pub fn areas(&mut self, step: &Step<'_>, areas: &mut Areas<S>) {
                match self { $(Self::$name(e) => e.areas(step, areas)),* }
            }

            /// See [`Hook::supply`].
            #[inline(always)]
            pub fn supply(&mut self, step: &Step<'_>, supply: &mut S, areas: &Areas<S>, pressure: S) {
                match self { $(Self::$name(e) => *supply = e.supply(step, *supply, areas, pressure)),* }
            }

            /// See [`Hook::stretch`].
            #[inline(always)]
            pub fn stretch(&mut self, step: &Step<'_>, pressures: &Facing<S>, stretch: &mut Stretch<S>) {
                match self { $(Self::$name(e) => e.stretch(step, pressures, stretch)),* }
            }

            /// See [`Hook::shown`].
            #[inline(always)]
            pub fn shown(&self, reading: S) -> S {
                match self { $(Self::$name(e) => e.shown(reading)),* }
            }

            /// See [`Hook::sense`].
            #[inline(always)]
            pub fn sense(&mut self, step: &Step<'_>, gauge: &mut S) {
                match self { $(Self::$name(e) => *gauge = e.sense(step, *gauge)),* }
            }

            /// See [`Hook::sample`].
            pub fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
                match self { $(Self::$name(e) => e.sample(inputs, row, reading)),* }
            }
        }
    };
}

catalogue! {
    drive_crosstalk::DriveCrosstalk,
    drive_saturation::DriveSaturation,
    coil_heating::CoilHeating,
    transport_delay::TransportDelay,
    valve_lag::ValveLag,
    valve_hysteresis::ValveHysteresis,
    valve_stiction::ValveStiction,
    valve_asymmetry::ValveAsymmetry,
    vent_restriction::VentRestriction,
    flow_function::FlowFunctionShape,
    heat_exchange::HeatExchange,
    wall_compliance::WallCompliance,
    wall_creep::WallCreep,
    line_restriction::LineRestriction,
    chamber_coupling::ChamberCoupling,
    supply_sag::SupplySag,
    supply_ripple::SupplyRipple,
    inflow_cycle::InflowCycle,
    sensor_lag::SensorLag,
    sensor_nonlinearity::SensorNonlinearity,
    sensor_drift::SensorDrift,
    sensor_crosstalk::SensorCrosstalk,
    valve_wear::ValveWear,
    stale_samples::StaleSamples,
    dead_band::DeadBand,
    rate_limit::RateLimit,
    offset::Offset,
    supply_level::SupplyLevel,
    exhaust_leak::ExhaustLeak,
    fill_leak::FillLeak,
    valve_gain::ValveGain,
    valve_centre::ValveCentre,
    chamber_volume::ChamberVolume,
    sensor_offset::SensorOffset,
    sensor_gain::SensorGain,
    supply_misstated::SupplyMisstated,
}

/// Position of an effect by its id.
#[must_use]
pub fn index_of(id: &str) -> Option<usize> {
    CATALOGUE.iter().position(|effect| effect.id == id)
}

/// No effect that can have a name has this id.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no effect is called {id}; there are {}", named().map(|(_, id)| id).collect::<Vec<_>>().join(", "))]
pub struct UnknownEffect {
    /// What was asked for.
    pub id: String,
}

/// Position of an effect that a diagnosis can name, by its id.
///
/// # Errors
/// [`UnknownEffect`], with the ids that there are.
pub fn nameable(id: &str) -> Result<usize, UnknownEffect> {
    let found = named().find(|(_, other)| *other == id);
    found.map(|(number, _)| number).ok_or_else(|| UnknownEffect { id: id.to_owned() })
}

/// Positions and ids of what a diagnosis can name.
fn named() -> impl Iterator<Item = (usize, &'static str)> {
    let can_have_a_name = |effect: &EffectInfo| effect.question != Question::Foil;
    CATALOGUE.iter().enumerate().filter(move |(_, e)| can_have_a_name(e)).map(|(k, e)| (k, e.id))
}
