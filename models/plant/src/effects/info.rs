//! What the catalogue says about an effect.

use super::parameter::EffectParameter;
use super::traits::{DerivedSize, Trait, Wave};
use super::{ChannelInputs, DriveInput, Plant};

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
    /// Which physical effect does the model lack? Asked after the base model was fitted to the
    /// recording.
    Structure,
    /// None: it stands for causes outside the catalogue, and is fitted along where the structure is
    /// asked for. A name that it explains as well as is withheld.
    Foil,
    /// Which calibrated parameter has moved? Asked against a reference; the fit of a recording
    /// absorbs it.
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
    /// Values at which the effect is tried: one inner slice per probe, one value per parameter.
    /// Empty when the probes are computed from the recording.
    pub probes: &'static [&'static [f64]],
    /// Effects it is easily confused with.
    pub rivals: &'static [&'static str],
    /// The excitation that tells it from them.
    pub separated_by: &'static str,
    /// Smallest value of the first parameter (distance from null) worth naming, in its unit: below
    /// it the recording's own timing and rounding can look the same.
    pub smallest: f64,
    /// What makes it different.
    pub traits: &'static [Trait],
    /// What a person at the rig looks at first when this is named.
    pub check: &'static str,
}

impl EffectInfo {
    /// Is it a part of the base model of such a plant, as far as it is usual? Two valves have a
    /// gain each anyway.
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

    /// Does what a board's loop controls move within a few milliseconds with it?
    #[must_use]
    pub fn is_fast_in_loop(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::FastInLoop))
    }

    /// Is it about a supply that the rig file states, and nobody has measured?
    #[must_use]
    pub fn needs_stated_supply(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::NeedsStatedSupply))
    }

    /// Does it happen at times that rows tell only roughly?
    #[must_use]
    pub fn is_roughly_timed(&self) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::RoughlyTimed))
    }

    /// Do the rows of a channel show by themselves that it is there?
    #[must_use]
    pub fn is_shown(&self, inputs: &ChannelInputs) -> bool {
        self.traits.iter().any(|t| matches!(t, Trait::Shown(by) if by(inputs)))
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
            Trait::NeedsNeighbourDrive => !inputs.neighbour_drive.is_empty(),
            Trait::NeedsStatedSupply => inputs.supply_pa.windows(2).all(|pair| pair[0] == pair[1]),
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

    /// Parameters of a size that hardly acts and that sound rigs have, with chambers of this mean
    /// volume (m^3).
    #[must_use]
    pub fn unnoticed(&self, volume_m3: f64) -> Option<Vec<f64>> {
        let unnoticed = |t: &Trait| if let Trait::Unnoticed(size) = t { Some(*size) } else { None };
        self.traits.iter().find_map(unnoticed).map(|size| size(volume_m3))
    }

    /// Position of a parameter by name.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }
}
