//! Effects: everything a real rig adds to the paper's model, switched on by name.
//!
//! Each file of this folder defines a family. An effect changes the resolved physics
//! ([`super::physics`]) of a channel, a board's joint or the supply; the equations themselves stand
//! where that physics is integrated or sampled.

mod changes;
mod definition;
mod drive;
mod effect;
mod gas;
mod off_catalogue;
mod parse;
mod passages;
mod resolve;
mod sensor;
mod supply;
mod table;

pub use definition::{EffectDefinition, EffectGroup, EffectParameter};
pub use effect::{Effect, Scope};
pub(super) use resolve::resolve;
pub use table::effects_table;

/// All effects, family by family.
pub fn catalogue() -> impl Iterator<Item = &'static EffectDefinition> {
    const FAMILIES: [&[EffectDefinition]; 7] = [
        supply::EFFECTS,
        drive::EFFECTS,
        passages::EFFECTS,
        gas::EFFECTS,
        sensor::EFFECTS,
        changes::EFFECTS,
        off_catalogue::EFFECTS,
    ];
    FAMILIES.into_iter().flatten()
}

/// The effect of that name.
#[must_use]
pub fn definition(id: &str) -> Option<&'static EffectDefinition> {
    catalogue().find(|d| d.id == id)
}
