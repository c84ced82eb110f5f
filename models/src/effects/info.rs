//! What the catalogue says about an effect.

use super::{ChannelInputs, DriveInput, Plant};
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
    /// Does it belong to what hangs on the valves, which may differ between recordings of one machine?
    pub of_load: bool,
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
            of_load: false,
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

    /// It belongs to what hangs on the valves: each recording of a machine may have its own.
    #[must_use]
    pub const fn of_load(mut self) -> Self {
        self.of_load = true;
        self
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

/// A sine in the supply that a recording shows, `cosine cos(w t) + sine sin(w t)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Amplitude of the cosine, over the gauge supply pressure.
    pub cosine: f64,
    /// Amplitude of the sine, over the gauge supply pressure.
    pub sine: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gauge supply pressure, Pa.
    pub gauge_pa: f64,
}

impl Wave {
    /// Amplitude over the gauge supply pressure.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Period, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.frequency_hz.recip()
    }
}

/// A size that several parameters of an effect make together and that is better known than each of them.
#[derive(Debug, Clone, Copy)]
pub struct DerivedSize {
    /// Name in reports, unique within the effect.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// What it means, in a few words.
    pub meaning: &'static str,
    /// From the effect's parameters and a flow, as the rate in kPa/s at which it changes the pressure of the nominal volume.
    pub of: fn(&[f64], f64) -> f64,
}

/// What makes an effect different from most, wherever it matters.
#[derive(Debug, Clone, Copy)]
pub enum Trait {
    /// Needs the pressure in the chamber on the other side of the joint.
    NeedsOpposite,
    /// Needs the pressure of the channel that the converter samples before.
    NeedsSampledBefore,
    /// Needs the flow that the other channels draw from the supply.
    NeedsOthersDraw,
    /// Needs one spool for both ways: two valves have a gain each in the base model.
    NeedsOneSpool,
    /// Its first parameter is a threshold: where it is passed a little later, everything after it is different, and there is no derivative.
    Thresholded,
    /// With it a board's loop hunts.
    LimitCycle,
    /// It happens at times that the rows tell only roughly.
    RoughlyTimed,
    /// It belongs to a recording of some minutes and means nothing over months: then another offset or gain is seen.
    WithinARecording,
    /// Its first parameter is the scale of the load: openings of valves cannot be told from it, but its ratios between recordings can.
    ScaleOfLoad,
    /// Its parameters make up for each other; together they are a size.
    Derives(DerivedSize),
    /// It comes back with a period of its own; its probes follow from a wave that the recording shows.
    Periodic(fn(&Wave) -> Vec<Vec<f64>>),
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
    /// What makes it different.
    pub traits: &'static [Trait],
    /// What a person at the rig looks at first when this is named.
    pub check: &'static str,
}

impl EffectInfo {
    /// Is it a part of the base model of such a plant, as far as it is usual? Two valves have a gain each anyway.
    #[must_use]
    pub fn in_base(&self, plant: &Plant) -> bool {
        !plant.model.is_regulator() && !plant.separate() && self.parameters.iter().any(|p| p.in_base)
    }

    /// Has its first parameter no derivative?
    #[must_use]
    pub fn is_thresholded(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::Thresholded))
    }

    /// What several of its parameters make together.
    #[must_use]
    pub fn derived(&self) -> Option<DerivedSize> {
        self.traits.iter().find_map(|t| if let Trait::Derives(size) = t { Some(*size) } else { None })
    }

    /// Is it the scale of what hangs on the valves?
    #[must_use]
    pub fn is_scale_of_load(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::ScaleOfLoad))
    }

    /// Does a board's loop hunt with it?
    #[must_use]
    pub fn makes_limit_cycles(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::LimitCycle))
    }

    /// Does it happen at times that rows tell only roughly?
    #[must_use]
    pub fn is_roughly_timed(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::RoughlyTimed))
    }

    /// Can it be seen from one recording to another, and not only within one?
    #[must_use]
    pub fn lasts(&self) -> bool {
        !self.traits.iter().any(|t| matches!(t, Trait::WithinARecording))
    }

    /// Does it need the pressures of other channels?
    #[must_use]
    pub fn needs_others_pressures(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::NeedsOpposite | Trait::NeedsSampledBefore))
    }

    /// Does it need the flow that the other channels draw?
    #[must_use]
    pub fn needs_others_draw(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::NeedsOthersDraw))
    }

    /// Is what it needs known of a channel with these inputs? The draw of others always is.
    #[must_use]
    pub fn is_known(&self, inputs: &ChannelInputs) -> bool {
        self.traits.iter().all(|t| match t {
            Trait::NeedsOpposite => !inputs.opposite_pa.is_empty(),
            Trait::NeedsSampledBefore => !inputs.sampled_before_pa.is_empty(),
            Trait::NeedsOneSpool => !matches!(inputs.drive, DriveInput::Separate { .. }),
            _ => true,
        })
    }

    /// Probes for a wave that the recording shows; none of an effect without a period.
    #[must_use]
    pub fn probes_of(&self, wave: &Wave) -> Vec<Vec<f64>> {
        let periodic = |t: &Trait| if let Trait::Periodic(probes) = t { Some(*probes) } else { None };
        self.traits.iter().find_map(periodic).map_or_else(Vec::new, |probes| probes(wave))
    }

    /// Position of a parameter by name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }
}
