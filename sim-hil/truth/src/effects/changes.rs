//! Parameters that have moved since a calibration.

use super::definition::{Apply, EffectDefinition, EffectGroup, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "supply_level",
        group: EffectGroup::Change,
        meaning: "the supply's pressure differs from nominal",
        parameters: &[size(
            "change_kpa",
            "kPa",
            (0.0, -50.0),
            (-400.0, 400.0),
            "added to the supply pressure",
        )],
        apply: Apply::Supply(|v, _, supply| supply.level_pa += 1e3 * v[0]),
    },
    EffectDefinition {
        id: "exhaust_leak",
        group: EffectGroup::Change,
        meaning: "a leak from the valve's port to the air, beside the valve",
        parameters: &[size(
            "share",
            "1",
            (0.0, 0.02),
            (0.0, 1.0),
            "conductance of the leak over that of the open valve",
        )],
        apply: Apply::Channel(|v, p, c| c.chamber.exhaust_leak += v[0] * p.valve.conductance_m3_per_s_pa),
    },
    EffectDefinition {
        id: "fill_leak",
        group: EffectGroup::Change,
        meaning: "a leak from the supply to the valve's port, past the fill edge",
        parameters: &[size(
            "share",
            "1",
            (0.0, 0.02),
            (0.0, 1.0),
            "conductance of the leak over that of the open valve",
        )],
        apply: Apply::Channel(|v, p, c| c.valve.fill_leak += v[0] * p.valve.conductance_m3_per_s_pa),
    },
    EffectDefinition {
        id: "valve_gain",
        group: EffectGroup::Change,
        meaning: "area per spool travel of both edges",
        parameters: &[size("factor", "1", (1.0, 0.8), (0.05, 5.0), "multiplies the slope of both edges")],
        apply: Apply::Channel(|v, _, c| c.valve.gain *= v[0]),
    },
    EffectDefinition {
        id: "valve_centre",
        group: EffectGroup::Change,
        meaning: "the spool's position at zero drive",
        parameters: &[size(
            "shift",
            "1",
            (0.0, 0.04),
            (-0.5, 0.5),
            "added to the spool's position; positive fills",
        )],
        apply: Apply::Channel(|v, _, c| c.valve.centre += v[0]),
    },
    EffectDefinition {
        id: "chamber_volume",
        group: EffectGroup::Change,
        meaning: "the chamber's volume",
        parameters: &[size("factor", "1", (1.0, 1.2), (0.1, 10.0), "multiplies the volume")],
        apply: Apply::Channel(|v, _, c| c.chamber.volume_factor *= v[0]),
    },
    EffectDefinition {
        id: "sensor_offset",
        group: EffectGroup::Change,
        meaning: "the sensor's zero",
        parameters: &[size("offset_kpa", "kPa", (0.0, 5.0), (-100.0, 100.0), "added to the reading")],
        apply: Apply::Channel(|v, _, c| c.sensor.offset_kpa += v[0]),
    },
    EffectDefinition {
        id: "sensor_gain",
        group: EffectGroup::Change,
        meaning: "the sensor's slope",
        parameters: &[size("factor", "1", (1.0, 1.04), (0.5, 1.5), "multiplies the reading")],
        apply: Apply::Channel(|v, _, c| c.sensor.gain *= v[0]),
    },
];
