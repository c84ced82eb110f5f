//! Effects between the drive and the spool.

use super::definition::{Apply, EffectDefinition, EffectGroup, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "transport_delay",
        group: EffectGroup::Structure,
        meaning: "dead time between the drive and the spool, in whole integration steps",
        parameters: &[size("delay_s", "s", (0.0, 0.012), (0.0, 0.5), "dead time")],
        apply: Apply::Channel(|v, _, c| c.drive.delay_s += v[0]),
    },
    EffectDefinition {
        id: "valve_lag",
        group: EffectGroup::Structure,
        meaning: "the spool follows the drive with a first-order lag (coil inductance, spring and mass)",
        parameters: &[size("time_constant_s", "s", (0.0, 0.02), (0.0, 0.5), "time constant of the spool")],
        apply: Apply::Channel(|v, _, c| c.drive.lag_s += v[0]),
    },
    EffectDefinition {
        id: "valve_hysteresis",
        group: EffectGroup::Structure,
        meaning: "play between the coil's force and the spool",
        parameters: &[size(
            "half_width",
            "1",
            (0.0, 0.05),
            (0.0, 0.4),
            "half the play, in units of full drive",
        )],
        apply: Apply::Channel(|v, _, c| c.drive.play_half_width = v[0]),
    },
    EffectDefinition {
        id: "valve_stiction",
        group: EffectGroup::Structure,
        meaning: "the spool stays until the force has moved by a threshold, then jumps to it",
        parameters: &[size(
            "threshold",
            "1",
            (0.0, 0.06),
            (0.0, 0.4),
            "break-away distance, in units of full drive",
        )],
        apply: Apply::Channel(|v, _, c| c.drive.stiction_threshold = v[0]),
    },
    EffectDefinition {
        id: "drive_saturation",
        group: EffectGroup::Structure,
        meaning: "the driver's current limit cuts the drive off below full scale (0.7 A where full drive asks for 1 A)",
        parameters: &[size(
            "limit",
            "1",
            (1.0, 0.7),
            (0.05, 1.0),
            "largest drive of either sign that reaches the coil",
        )],
        apply: Apply::Channel(|v, _, c| c.drive.limit = Some(v[0])),
    },
];
