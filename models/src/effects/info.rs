//! What the catalogue says about an effect.

use super::Plant;
use crate::model::Scale;

/// How far one set of an effect's parameters reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Each channel has its own: valves, chambers, sensors.
    Channel,
    /// One thing that all channels share: the supply.
    Rig,
}

/// In which of the two questions an effect is a possible answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// Which physical effect does the model lack? Asked after the base model was fitted to the recording.
    Structure,
    /// None: it stands for causes outside the catalogue, and is fitted along where the structure is asked for. A name that it explains as
    /// well as is withheld.
    Foil,
    /// Which calibrated parameter has moved? Asked against a reference; the fit of a recording absorbs it.
    Change,
}

/// Which base models it makes sense for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Domain {
    /// A valve and a chamber.
    Valve,
    /// A pressure regulator with its own loop.
    Regulator,
    /// Both; of a regulator, the command takes the place of the drive.
    Both,
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name in reports and files, unique within the effect.
    pub name: &'static str,
    /// Unit, `1` when it has none.
    pub unit: &'static str,
    /// Smallest value that is fitted.
    pub lower: f64,
    /// Largest value that is fitted.
    pub upper: f64,
    /// Value at which the effect is absent (as closely as the bounds allow).
    pub null: f64,
    /// Scale of fitting.
    pub scale: Scale,
    /// Largest distance from `null` that is usual on sound rigs, of the logarithm where that is fitted; infinite where the parameter says
    /// nothing about how large the effect is.
    pub usual: f64,
    /// Is it free, as far as is usual, in every base model of a valve?
    pub in_base: bool,
    /// What it means, in a few words.
    pub meaning: &'static str,
}

impl EffectParameter {
    /// A parameter fitted as it is; the range is (lower, null, upper).
    #[must_use]
    pub const fn linear(
        name: &'static str,
        unit: &'static str,
        (lower, null, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        Self {
            name,
            unit,
            lower,
            upper,
            null,
            scale: Scale::Linear,
            usual: f64::INFINITY,
            in_base: false,
            meaning,
        }
    }

    /// A positive parameter fitted by its logarithm; the range is (lower, null, upper).
    #[must_use]
    pub const fn logarithmic(
        name: &'static str,
        unit: &'static str,
        (lower, null, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        let mut parameter = Self::linear(name, unit, (lower, null, upper), meaning);
        parameter.scale = Scale::Logarithmic;
        parameter
    }
}

impl EffectParameter {
    /// With the largest value that is usual on sound rigs.
    #[must_use]
    pub const fn usual_to(mut self, distance: f64) -> Self {
        self.usual = distance;
        self
    }

    /// As [`usual_to`](Self::usual_to), and free that far in every base model of a valve: without it, a fit bends what is there instead.
    #[must_use]
    pub const fn in_base_to(mut self, distance: f64) -> Self {
        self.in_base = true;
        self.usual_to(distance)
    }

    /// Where it is fitted: anywhere, or as far as is usual.
    #[must_use]
    pub fn bounds(&self, usual: bool) -> (f64, f64) {
        let (low, high) = match self.scale {
            Scale::Linear => (self.null - self.usual, self.null + self.usual),
            Scale::Logarithmic => (self.null * (-self.usual).exp(), self.null * self.usual.exp()),
        };
        if usual { (low.max(self.lower), high.min(self.upper)) } else { (self.lower, self.upper) }
    }

    /// Distance of a value from `null`, on the scale of fitting.
    #[must_use]
    pub fn distance(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.null).abs(),
            Scale::Logarithmic => (value / self.null).ln().abs(),
        }
    }
}

/// An entry of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct EffectInfo {
    /// Name in reports and files.
    pub id: &'static str,
    /// Name for people.
    pub title: &'static str,
    /// The physics in a sentence or two.
    pub physics: &'static str,
    /// The equation that is simulated.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// Which question it answers.
    pub question: Question,
    /// Where it makes sense.
    pub domain: Domain,
    /// One for the rig or one a channel.
    pub reach: Reach,
    /// The parameters, in the order in which they are installed.
    pub parameters: &'static [EffectParameter],
    /// Values at which the effect is tried: one inner slice per probe, one value per parameter. Empty when the probes are
    /// computed from the recording.
    pub probes: &'static [&'static [f64]],
    /// Effects it is easily confused with.
    pub rivals: &'static [&'static str],
    /// The excitation that tells it from them.
    pub separated_by: &'static str,
    /// Smallest value of the first parameter (distance from null) worth naming, in its unit: below it the recording's own
    /// timing and rounding can look the same.
    pub smallest: f64,
    /// What a person at the rig looks at first when this is named.
    pub check: &'static str,
}

impl EffectInfo {
    /// Is it a part of the base model of such a plant, as far as it is usual? Two valves have a gain each anyway.
    #[must_use]
    pub fn in_base(&self, plant: &Plant) -> bool {
        !plant.model.is_regulator() && !plant.separate() && self.parameters.iter().any(|p| p.in_base)
    }

    /// Position of a parameter by name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }
}
