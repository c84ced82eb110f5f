//! Effects of the shared supply.

use super::super::physics::GAS_CONSTANT;
use super::super::physics::SupplyLine;
use super::definition::{Apply, EffectDefinition, EffectGroup, shape, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "supply_sag",
        group: EffectGroup::Structure,
        meaning: "line and regulator resistance between the source and a manifold volume all valves draw from",
        parameters: &[
            size(
                "drop_kpa",
                "kPa",
                (0.0, 40.0),
                (0.0, 300.0),
                "drop at the flow of one fully open valve into an empty chamber",
            ),
            shape("lag_s", "s", 0.03, (0.002, 2.0), "time constant of the manifold behind the resistance"),
            shape("quadratic", "1", 0.3, (0.0, 1.0), "share of the drop that grows with the flow squared"),
        ],
        apply: Apply::Supply(|v, p, supply| {
            let flow = p.reference_flow();
            let drop = 1e3 * v[0];
            // The slope of the drop at the reference flow, with the manifold's volume, makes the
            // lag.
            let slope = drop * (1.0 + v[2]) / flow;
            supply.line = Some(SupplyLine {
                linear: drop * (1.0 - v[2]) / flow,
                quadratic: drop * v[2] / (flow * flow),
                volume_m3: v[1] * GAS_CONSTANT * p.ambient.temperature_k / slope,
            });
        }),
    },
    EffectDefinition {
        id: "supply_ripple",
        group: EffectGroup::Structure,
        meaning: "compressor cycle: the source rises for 30 % of the period and falls for the rest, from a random phase",
        parameters: &[
            size("amplitude_kpa", "kPa", (0.0, 20.0), (0.0, 200.0), "half the swing"),
            shape("period_s", "s", 6.0, (0.2, 200.0), "time from one charge to the next"),
        ],
        apply: Apply::Supply(|v, _, supply| supply.ripple = Some((1e3 * v[0], v[1]))),
    },
];
