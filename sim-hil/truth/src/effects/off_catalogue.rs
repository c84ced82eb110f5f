//! Effects in nobody's catalogue, for tests that hide one: a diagnosis must call them unexplained.

use super::super::physics::{BurstPhysics, RelayRegulator, WaterPhysics};
use super::definition::{Apply, EffectDefinition, EffectGroup, shape, size};

pub(super) const EFFECTS: &[EffectDefinition] = &[
    EffectDefinition {
        id: "line_water",
        group: EffectGroup::OffCatalogue,
        meaning: "slugs of water pass the valve at random and block a part of its area, filling and venting",
        parameters: &[
            size("depth", "1", (0.0, 0.5), (0.0, 0.95), "share of the area a slug blocks"),
            shape("gap_s", "s", 2.0, (0.05, 100.0), "mean time between slugs"),
            shape("slug_s", "s", 0.6, (0.02, 20.0), "mean length of a slug"),
        ],
        apply: Apply::Channel(|v, _, c| {
            c.ageing.water = Some(WaterPhysics { depth: v[0], mean_gap_s: v[1], mean_slug_s: v[2] });
        }),
    },
    EffectDefinition {
        id: "chamber_burst",
        group: EffectGroup::OffCatalogue,
        meaning: "a crack in the chamber grows while the pressure is above a threshold",
        parameters: &[
            size(
                "growth",
                "1",
                (0.0, 0.1),
                (0.0, 10.0),
                "leak gained in 100 s at 100 kPa above the threshold, over the open valve's conductance",
            ),
            shape("threshold_kpa", "kPa", 180.0, (0.0, 1000.0), "gauge pressure above which it grows"),
        ],
        apply: Apply::Channel(|v, p, c| {
            c.ageing.burst = Some(BurstPhysics {
                growth: v[0] * p.valve.conductance_m3_per_s_pa / (100.0 * 1e5),
                threshold_pa: 1e3 * v[1],
            });
        }),
    },
    EffectDefinition {
        id: "supply_temperature",
        group: EffectGroup::OffCatalogue,
        meaning: "the supply air's temperature cycles (dryer, sun on the tank)",
        parameters: &[
            size("amplitude_k", "K", (0.0, 30.0), (0.0, 100.0), "half the swing"),
            shape("period_s", "s", 45.0, (1.0, 1e5), "period"),
        ],
        apply: Apply::Supply(|v, _, supply| supply.temperature_cycle = Some((v[0], v[1]))),
    },
    EffectDefinition {
        id: "spool_stick",
        group: EffectGroup::OffCatalogue,
        meaning: "a burr holds the spool at one position until the force is a distance away",
        parameters: &[
            size(
                "tear_off",
                "1",
                (0.0, 0.15),
                (0.0, 0.5),
                "distance that tears it off, in units of full drive",
            ),
            shape("position", "1", 0.15, (-1.0, 1.0), "where it sticks"),
        ],
        apply: Apply::Channel(|v, _, c| c.drive.sticking_spot = Some((v[1], v[0]))),
    },
    EffectDefinition {
        id: "drive_crosstalk",
        group: EffectGroup::OffCatalogue,
        meaning: "a part of the drive of the channel before (3 for channel 0) is induced into this one's",
        parameters: &[size("share", "1", (0.0, 0.1), (-0.5, 0.5), "share of the neighbour's drive")],
        apply: Apply::Channel(|v, _, c| c.drive.crosstalk = v[0]),
    },
    EffectDefinition {
        id: "coil_heating",
        group: EffectGroup::OffCatalogue,
        meaning: "the valve's gain falls as its coil heats up with the square of the duty",
        parameters: &[
            size("loss", "1", (0.0, 0.5), (0.0, 0.9), "share of the gain lost in the long run at full duty"),
            shape("time_constant_s", "s", 5.0, (0.05, 1000.0), "thermal time constant"),
        ],
        apply: Apply::Channel(|v, _, c| c.ageing.heating = Some((v[0], v[1]))),
    },
    EffectDefinition {
        id: "regulator_backlash",
        group: EffectGroup::OffCatalogue,
        meaning: "a tank that is refilled only when it has fallen half a band below nominal, until half a band above",
        parameters: &[
            size("band_kpa", "kPa", (0.0, 60.0), (0.0, 300.0), "width of the band"),
            shape("tank_l", "l", 3.0, (0.2, 500.0), "volume of the tank"),
            shape("refill", "1", 3.0, (1.0, 50.0), "refill over the flow of one fully open valve"),
        ],
        apply: Apply::Supply(|v, p, supply| {
            supply.relay = Some(RelayRegulator {
                half_band_pa: 500.0 * v[0],
                volume_m3: 1e-3 * v[1],
                refill_kg_per_s: v[2] * p.reference_flow(),
            });
        }),
    },
    EffectDefinition {
        id: "sensor_hysteresis",
        group: EffectGroup::OffCatalogue,
        meaning: "the sensor's diaphragm rubs: a falling pressure reads higher than a rising one",
        parameters: &[size("half_width_kpa", "kPa", (0.0, 3.0), (0.0, 50.0), "half of the gap")],
        apply: Apply::Channel(|v, _, c| c.sensor.play_kpa = v[0]),
    },
    EffectDefinition {
        id: "driver_resolution",
        group: EffectGroup::OffCatalogue,
        meaning: "the valve's driver knows a few levels only, and puts out the nearest",
        parameters: &[size(
            "step",
            "1",
            (0.0, 0.1),
            (0.0, 1.0),
            "distance of two levels, in units of full drive",
        )],
        apply: Apply::Channel(|v, _, c| c.drive.resolution = v[0]),
    },
];
