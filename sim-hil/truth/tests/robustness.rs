//! Whatever is switched on within the documented ranges, the plant is refused by name or stays
//! physical.
use pneudrive_truth::{
    ChannelId, Effect, EffectDefinition, Plant, PlantError, PlantParameters, Scope, catalogue,
};
use proptest::prelude::*;

/// Any effect with every number anywhere in its range.
fn any_effect() -> impl Strategy<Value = Effect> {
    let all: Vec<&'static EffectDefinition> = catalogue().collect();
    (0..all.len(), proptest::collection::vec(0.0..=1.0_f64, 4)).prop_map(move |(index, shares)| {
        let values: Vec<(&str, f64)> = all[index]
            .parameters
            .iter()
            .zip(shares)
            .map(|(p, share)| (p.name, p.min + share * (p.max - p.min)))
            .collect();
        Effect::new(all[index].id, &values, Scope::Rig).unwrap()
    })
}

fn few_effects() -> impl Strategy<Value = Vec<Effect>> {
    proptest::collection::vec(any_effect(), 1..5).prop_map(|mut effects| {
        let mut seen = std::collections::BTreeSet::new();
        effects.retain(|effect| seen.insert(effect.id()));
        effects
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn stays_physical_or_is_refused(effects in few_effects(), seed in 0..1000_u64, drives in proptest::collection::vec(-1.0..=1.0_f64, 8)) {
        let parameters = PlantParameters { channels: 2, ..PlantParameters::default() };
        let mut plant = match Plant::new(parameters, &effects, seed) {
            Ok(plant) => plant,
            Err(PlantError::TooStiff { .. } | PlantError::Parameter { .. }) => return Ok(()),
            Err(other) => return Err(TestCaseError::fail(format!("{other}"))),
        };
        for (k, drive) in drives.iter().enumerate() {
            for index in 0..2 {
                let sign = if index == 0 { 1.0 } else { -1.0 };
                plant.set_drive(ChannelId { board: 0, channel: index }, sign * drive).unwrap();
            }
            plant.advance_to(100_000_000 * (k as u64 + 1));
            for index in 0..2 {
                let t = plant.truth(ChannelId { board: 0, channel: index }).unwrap();
                // 550 + 400 + 200 + 150 kPa is the most a supply can reach, twice that a squeezed
                // chamber.
                prop_assert!(t.pressure_pa > 1e3 && t.pressure_pa < 3e6, "{t:?} {effects:?}");
                prop_assert!(t.port_pa > 1e3 && t.port_pa < 3e6, "{t:?}");
                prop_assert!(t.volume_m3 > 0.0 && t.temperature_k > 50.0 && t.temperature_k < 1500.0, "{t:?}");
                prop_assert!(t.mass_kg > 0.0 && t.spool.abs() <= 1.0, "{t:?}");
            }
            plant.sample(0).unwrap();
        }
    }
}
