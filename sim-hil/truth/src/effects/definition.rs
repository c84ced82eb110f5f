//! What an effect is: a name, numbers with units, and a change to the resolved physics.

use super::super::parameters::PlantParameters;
use super::super::physics::{ChannelPhysics, JointPhysics, SupplyPhysics};

/// Where an effect belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectGroup {
    /// In the catalogue of structural effects a diagnosis can name.
    Structure,
    /// A changed parameter, which a diagnosis names with a reference only.
    Change,
    /// In nobody's catalogue: a diagnosis must call it unexplained.
    OffCatalogue,
}

/// One number of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name, with the unit where there is one.
    pub name: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// The value at which the effect is off; `None` for a number that only shapes it.
    pub null: Option<f64>,
    /// Value when none is given: of the first parameter the moderate size, of the others the usual
    /// one.
    pub moderate: f64,
    /// Smallest accepted value.
    pub min: f64,
    /// Largest accepted value.
    pub max: f64,
}

/// How an effect changes the rig. The numbers come in the order of the parameters.
#[derive(Debug, Clone, Copy)]
pub(in super::super) enum Apply {
    Channel(fn(&[f64], &PlantParameters, &mut ChannelPhysics)),
    Joint(fn(&[f64], &PlantParameters, &mut JointPhysics)),
    Supply(fn(&[f64], &PlantParameters, &mut SupplyPhysics)),
}

/// An effect that can be switched on.
#[derive(Debug, Clone, Copy)]
pub struct EffectDefinition {
    /// Its name.
    pub id: &'static str,
    /// Where it belongs.
    pub group: EffectGroup,
    /// What happens physically.
    pub meaning: &'static str,
    /// Its numbers; the first is the one `id=value` sets.
    pub parameters: &'static [EffectParameter],
    pub(in super::super) apply: Apply,
}

impl EffectDefinition {
    /// Position of a parameter.
    #[must_use]
    pub fn parameter_index(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// What it can be limited to: `one channel`, `a whole board` or `the whole rig`.
    #[must_use]
    pub fn acts_on(&self) -> &'static str {
        match self.apply {
            Apply::Channel(_) => "one channel",
            Apply::Joint(_) => "a whole board",
            Apply::Supply(_) => "the whole rig",
        }
    }
}

/// A parameter that makes the effect: off at `null`.
pub(super) const fn size(
    name: &'static str,
    unit: &'static str,
    (null, moderate): (f64, f64),
    (min, max): (f64, f64),
    meaning: &'static str,
) -> EffectParameter {
    EffectParameter { name, meaning, unit, null: Some(null), moderate, min, max }
}

/// A parameter that shapes the effect.
pub(super) const fn shape(
    name: &'static str,
    unit: &'static str,
    usual: f64,
    (min, max): (f64, f64),
    meaning: &'static str,
) -> EffectParameter {
    EffectParameter { name, meaning, unit, null: None, moderate: usual, min, max }
}
