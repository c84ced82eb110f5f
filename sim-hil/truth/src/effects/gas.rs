//! Effects of the gas and of the volume that holds it.

use super::super::physics::GasPhysics;
use super::definition::{Apply, EffectDefinition, EffectGroup, shape, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "heat_exchange",
        group: EffectGroup::Structure,
        meaning: "mass and energy balance with a wall at ambient temperature instead of a fixed gas temperature",
        parameters: &[size(
            "time_constant_s",
            "s",
            (0.0, 0.5),
            (0.0, 1e6),
            "time constant of the gas temperature at 250 kPa absolute; 0 is off (fixed temperature)",
        )],
        apply: Apply::Channel(|v, p, c| {
            // A larger chamber of the spread has as much more wall: the time constant is every
            // channel's own.
            let wall_w_per_k = p.wall_conductance(v[0]) * c.chamber.volume_factor;
            c.chamber.gas = GasPhysics::Balance { wall_w_per_k };
        }),
    },
    EffectDefinition {
        id: "wall_compliance",
        group: EffectGroup::Structure,
        meaning: "the chamber's volume grows in proportion to the gauge pressure, at once",
        parameters: &[size(
            "compliance_per_mpa",
            "1/MPa",
            (0.0, 0.8),
            (0.0, 5.0),
            "relative volume per pressure",
        )],
        apply: Apply::Channel(|v, _, c| c.chamber.compliance += 1e-6 * v[0]),
    },
    EffectDefinition {
        id: "wall_creep",
        group: EffectGroup::Structure,
        meaning: "viscoelastic wall (Kelvin-Voigt): the volume relaxes towards its stretch under pressure",
        parameters: &[
            size(
                "compliance_per_mpa",
                "1/MPa",
                (0.0, 0.8),
                (0.0, 5.0),
                "relative volume per pressure in the long run",
            ),
            shape("time_constant_s", "s", 3.0, (0.01, 1000.0), "relaxation time"),
        ],
        apply: Apply::Channel(|v, _, c| c.chamber.creep = Some((1e-6 * v[0], v[1]))),
    },
    EffectDefinition {
        id: "chamber_coupling",
        group: EffectGroup::Structure,
        meaning: "the joint bends under the pressure difference of a pair, which lengthens one chamber and shortens the other",
        parameters: &[size(
            "angle_rad_per_mpa",
            "rad/MPa",
            (0.0, 1.5),
            (0.0, 4.0),
            "bending per pressure difference at rest",
        )],
        apply: Apply::Joint(|v, _, joint| {
            joint.free = true;
            joint.angle_per_pa = 1e-6 * v[0];
        }),
    },
];
