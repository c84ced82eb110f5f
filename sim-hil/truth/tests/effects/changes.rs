//! What changed parameters do.

use super::bench::{channel, filled, flows, near, reading, rig, run, supply_kpa};

/// Asserts it of an effect of this group; `false` of another.
pub fn assert_direction(id: &str) -> bool {
    match id {
        "supply_level" => near(supply_kpa(&rig("supply_level=-50", 0.0)), 500.0, 1e-9),
        "exhaust_leak" => {
            let mut plant = rig("exhaust_leak=0.02", 300.0);
            run(&mut plant, 0.0, 50e-6);
            let leak = plant.truth(channel(0)).unwrap().leak_kg_per_s;
            near(leak, 0.02 * 3e-9 * 1.185 * 401_325.0, 1e-9);
            let [plain, with] = filled("exhaust_leak=0.02", 0.0, 300.0, 0.5);
            assert!(with < plain - 3.0, "{with} {plain}");
        }
        "fill_leak" => {
            let [plain, with] = filled("fill_leak=0.02", 0.0, 100.0, 0.5);
            assert!(with > plain + 5.0, "{with} {plain}");
        }
        "valve_gain" => {
            for drive in [1.0, -1.0] {
                let [plain, with] = flows("valve_gain=0.8", drive, 300.0);
                near(with / plain, 0.8, 1e-3);
            }
        }
        "valve_centre" => {
            let [plain, with] = filled("valve_centre=0.06", 0.0, 200.0, 0.5);
            assert!(with > plain + 5.0, "{with} {plain}");
            let [plain, with] = filled("valve_centre=-0.06", 0.0, 200.0, 0.5);
            assert!(with < plain - 2.0, "{with} {plain}");
        }
        "chamber_volume" => {
            let [plain, with] = filled("chamber_volume=1.2", 1.0, 0.0, 0.1);
            near(plain / with, 1.2, 1e-4); // but for what leaks past the vent edge
        }
        "sensor_offset" => near(reading(&mut rig("sensor_offset=5", 200.0), 0), 205.0, 0.11),
        "sensor_gain" => near(reading(&mut rig("sensor_gain=1.04", 200.0), 0), 208.0, 0.11),
        _ => return false,
    }
    true
}
