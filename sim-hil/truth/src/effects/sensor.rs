//! Effects of the sensor, the converter and the board's sampling; and the wearing valve.

use super::definition::{Apply, EffectDefinition, EffectGroup, shape, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "sensor_lag",
        group: EffectGroup::Structure,
        meaning: "first-order filter between the pressure and the sensor's output",
        parameters: &[size("time_constant_s", "s", (0.0, 0.02), (0.0, 1.0), "time constant of the filter")],
        apply: Apply::Channel(|v, _, c| c.sensor.lag_s = v[0]),
    },
    EffectDefinition {
        id: "sensor_nonlinearity",
        group: EffectGroup::Structure,
        meaning: "parabolic sensor characteristic, right at 0 and at 100 psi",
        parameters: &[size(
            "bow_kpa",
            "kPa",
            (0.0, 25.0),
            (-100.0, 100.0),
            "excess reading in the middle of the range",
        )],
        apply: Apply::Channel(|v, _, c| c.sensor.bow_kpa = v[0]),
    },
    EffectDefinition {
        id: "sensor_drift",
        group: EffectGroup::Structure,
        meaning: "the sensor's zero moves exponentially to a new value (warm-up)",
        parameters: &[
            size("final_kpa", "kPa", (0.0, 8.0), (-100.0, 100.0), "zero reached in the long run"),
            shape("time_constant_s", "s", 150.0, (1.0, 1e5), "time constant of the warm-up"),
        ],
        apply: Apply::Channel(|v, _, c| c.sensor.drift = Some((v[0], v[1]))),
    },
    EffectDefinition {
        id: "sensor_crosstalk",
        group: EffectGroup::Structure,
        meaning: "the converter's capacitor keeps a part of the channel sampled before (0 after 3 of the scan before)",
        parameters: &[size("share", "1", (0.0, 0.04), (0.0, 0.5), "share of the voltage sampled before")],
        apply: Apply::Channel(|v, _, c| c.sensor.crosstalk = v[0]),
    },
    EffectDefinition {
        id: "valve_wear",
        group: EffectGroup::Structure,
        meaning: "the valve's area per spool travel changes exponentially in time",
        parameters: &[size(
            "change_per_100_s",
            "1",
            (0.0, -0.15),
            (-0.95, 2.0),
            "relative change of the gain in 100 s",
        )],
        apply: Apply::Channel(|v, _, c| c.ageing.wear_per_s = v[0].ln_1p() / 100.0),
    },
    EffectDefinition {
        id: "stale_samples",
        group: EffectGroup::Structure,
        meaning: "the converter's result is repeated for spells of exponential length",
        parameters: &[
            size("share", "1", (0.0, 0.2), (0.0, 0.95), "share of the time"),
            shape("spell_s", "s", 0.04, (0.001, 10.0), "mean length of a spell"),
        ],
        apply: Apply::Channel(|v, _, c| c.sensor.stale = Some((v[0], v[1]))),
    },
];
