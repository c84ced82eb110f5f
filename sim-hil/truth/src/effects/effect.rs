//! An effect with its numbers and its place.

use core::fmt;

use super::super::error::EffectError;
use super::super::id::ChannelId;
use super::definition::{Apply, EffectDefinition};
use super::{catalogue, definition};

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// On every channel.
    Rig,
    /// On the channels of one board.
    Board(u8),
    /// On one channel.
    Channel(ChannelId),
}

impl Scope {
    /// Whether a channel lies within.
    #[must_use]
    pub fn covers(self, channel: ChannelId) -> bool {
        match self {
            Scope::Rig => true,
            Scope::Board(board) => board == channel.board,
            Scope::Channel(own) => own == channel,
        }
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Scope::Rig => write!(f, "the whole rig"),
            Scope::Board(board) => write!(f, "b{board}"),
            Scope::Channel(channel) => write!(f, "{channel}"),
        }
    }
}

/// An effect of the [`catalogue`] with values for its parameters and the place where it acts.
///
/// Written and read as `id` (moderate size), `id=value` (its first parameter) or
/// `id:name=value,name=value`, each with an optional `@b0` (a board) or `@b0c2` (a channel).
#[derive(Debug, Clone)]
pub struct Effect {
    definition: &'static EffectDefinition,
    values: Vec<f64>,
    scope: Scope,
}

impl Effect {
    /// An effect with the named values; parameters not named take their moderate or usual value.
    ///
    /// # Errors
    /// No such effect or parameter, a value outside its range, or a scope finer than the effect.
    pub fn new(id: &str, values: &[(&str, f64)], scope: Scope) -> Result<Self, EffectError> {
        let definition = known(id)?;
        let mut all: Vec<f64> = definition.parameters.iter().map(|p| p.moderate).collect();
        for (name, value) in values {
            let index = definition.parameter_index(name).ok_or_else(|| EffectError::UnknownParameter {
                id: definition.id,
                name: (*name).to_owned(),
                known: definition.parameters.iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
            })?;
            all[index] = *value;
        }
        Self::checked(definition, all, scope)
    }

    /// An effect with the given value of its first parameter.
    ///
    /// # Errors
    /// As [`Effect::new`].
    pub fn of_size(id: &str, value: f64, scope: Scope) -> Result<Self, EffectError> {
        let name = known(id)?.parameters[0].name;
        Self::new(id, &[(name, value)], scope)
    }

    /// An effect of moderate size on the whole rig.
    ///
    /// # Errors
    /// No such effect.
    pub fn moderate(id: &str) -> Result<Self, EffectError> {
        Self::new(id, &[], Scope::Rig)
    }

    /// An effect with its sizes at their null values: it changes nothing.
    ///
    /// # Errors
    /// No such effect.
    pub fn null(id: &str) -> Result<Self, EffectError> {
        let definition = known(id)?;
        let values = definition.parameters.iter().map(|p| p.null.unwrap_or(p.moderate)).collect();
        Self::checked(definition, values, Scope::Rig)
    }

    /// A rig as one would find it: small amounts of what every rig has, so that the paper's model
    /// does not quite fit it.
    ///
    /// Wall heat exchange of 0.6 s, a spool lag of 4 ms, play of 1 % of full drive to either side,
    /// tubes of 10 ml that pass seven times as much as the valve, a supply that sags by 15 kPa
    /// under one open valve, a wall that gives by 0.2 per MPa.
    #[must_use]
    pub fn realistic() -> Vec<Self> {
        let of = |id, values: &[(&str, f64)]| Self::new(id, values, Scope::Rig).ok();
        [
            of("heat_exchange", &[("time_constant_s", 0.6)]),
            of("valve_lag", &[("time_constant_s", 0.004)]),
            of("valve_hysteresis", &[("half_width", 0.01)]),
            of("line_restriction", &[("restriction", 0.15), ("volume_ml", 10.0)]),
            of("supply_sag", &[("drop_kpa", 15.0)]),
            of("wall_compliance", &[("compliance_per_mpa", 0.2)]),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn checked(
        definition: &'static EffectDefinition,
        values: Vec<f64>,
        scope: Scope,
    ) -> Result<Self, EffectError> {
        for (parameter, &value) in definition.parameters.iter().zip(&values) {
            if !(parameter.min..=parameter.max).contains(&value) {
                return Err(EffectError::Value {
                    id: definition.id,
                    name: parameter.name,
                    value,
                    unit: parameter.unit,
                    min: parameter.min,
                    max: parameter.max,
                });
            }
        }
        let too_fine = match definition.apply {
            Apply::Channel(_) => false,
            Apply::Joint(_) => matches!(scope, Scope::Channel(_)),
            Apply::Supply(_) => scope != Scope::Rig,
        };
        if too_fine {
            return Err(EffectError::Scope {
                id: definition.id,
                acts_on: definition.acts_on(),
                scope: scope.to_string(),
            });
        }
        Ok(Self { definition, values, scope })
    }

    /// What kind of effect it is.
    #[must_use]
    pub fn definition(&self) -> &'static EffectDefinition {
        self.definition
    }

    /// Its name.
    #[must_use]
    pub fn id(&self) -> &'static str {
        self.definition.id
    }

    /// Its values, in the order of the definition's parameters.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Where it acts.
    #[must_use]
    pub fn scope(&self) -> Scope {
        self.scope
    }

    /// Whether all its sizes are at their null values, so that it changes nothing.
    #[must_use]
    pub fn is_null(&self) -> bool {
        let at_null =
            |(p, v): (&super::EffectParameter, &f64)| p.null.is_none_or(|null| (v - null).abs() <= 0.0);
        self.definition.parameters.iter().zip(&self.values).all(at_null)
    }
}

fn known(id: &str) -> Result<&'static EffectDefinition, EffectError> {
    definition(id).ok_or_else(|| EffectError::UnknownId {
        id: id.to_owned(),
        known: catalogue().map(|d| d.id).collect::<Vec<_>>().join(", "),
    })
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id() == other.id() && self.values == other.values && self.scope == other.scope
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.id())?;
        for (k, (parameter, value)) in self.definition.parameters.iter().zip(&self.values).enumerate() {
            write!(f, "{}{}={value}", if k == 0 { ':' } else { ',' }, parameter.name)?;
        }
        match self.scope {
            Scope::Rig => Ok(()),
            scope => write!(f, "@{scope}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{Plant, PlantParameters};
    use super::*;

    #[test]
    fn the_realistic_rig_has_all_its_effects_and_runs() {
        let effects = Effect::realistic();
        assert_eq!(effects.len(), 6);
        let mut plant = Plant::new(PlantParameters::default(), &effects, 1).unwrap();
        plant.advance_to(1_000_000);
    }
}
