//! Effects of the passages the gas takes: edges, exhaust, tubes.

use super::super::physics::SideVolume;
use super::definition::{Apply, EffectDefinition, EffectGroup, shape, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "valve_asymmetry",
        group: EffectGroup::Structure,
        meaning: "the vent edge opens by another area per spool travel than the fill edge",
        parameters: &[size(
            "vent_over_fill",
            "1",
            (1.0, 0.7),
            (0.1, 5.0),
            "slope of the vent edge over that of the fill edge",
        )],
        apply: Apply::Channel(|v, _, c| c.valve.vent_gain *= v[0]),
    },
    EffectDefinition {
        id: "vent_restriction",
        group: EffectGroup::Structure,
        meaning: "muffler or fitting behind the vent edge: a small volume and an orifice to the air",
        parameters: &[
            size(
                "restriction",
                "1",
                (0.0, 0.8),
                (0.0, 5.0),
                "conductance of the open valve over that of the orifice",
            ),
            shape("volume_ml", "ml", 8.0, (1.0, 100.0), "volume between the vent edge and the orifice"),
        ],
        apply: Apply::Channel(|v, p, c| {
            c.chamber.muffler = Some(SideVolume {
                conductance: p.valve.conductance_m3_per_s_pa / v[0],
                volume_m3: 1e-6 * v[1],
            });
        }),
    },
    EffectDefinition {
        id: "flow_function",
        group: EffectGroup::Structure,
        meaning: "critical ratio or subsonic exponent of the metering edges differ from nominal",
        parameters: &[
            size(
                "critical_ratio_change",
                "1",
                (0.0, 0.2),
                (-0.3, 0.5),
                "added to the nominal critical ratio",
            ),
            size("exponent_change", "1", (0.0, 0.0), (-0.3, 0.5), "added to the nominal subsonic exponent"),
        ],
        apply: Apply::Channel(|v, _, c| {
            c.chamber.flow = c.chamber.flow.changed_by(v[0], v[1]);
        }),
    },
    EffectDefinition {
        id: "line_restriction",
        group: EffectGroup::Structure,
        meaning: "tube between the valve (with the sensor) and the chamber: a second small volume and an orifice",
        parameters: &[
            size(
                "restriction",
                "1",
                (0.0, 0.3),
                (0.0, 5.0),
                "conductance of the open valve over that of the tube",
            ),
            shape("volume_ml", "ml", 15.0, (2.0, 200.0), "volume of the tube"),
        ],
        apply: Apply::Channel(|v, p, c| {
            c.chamber.line = Some(SideVolume {
                conductance: p.valve.conductance_m3_per_s_pa / v[0],
                volume_m3: 1e-6 * v[1],
            });
        }),
    },
];
