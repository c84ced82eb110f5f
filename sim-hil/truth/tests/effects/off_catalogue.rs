//! What the effects do that are in nobody's catalogue.

use super::bench::{AMBIENT, channel, near, reading, rig, run, spool, supply_kpa};

/// Asserts it of an effect of this group; `false` of another.
pub fn assert_direction(id: &str) -> bool {
    match id {
        "line_water" => line_water(),
        "chamber_burst" => {
            let leak = |initial: f64| {
                let mut plant = rig("chamber_burst:growth=1,threshold_kpa=180", initial);
                run(&mut plant, 0.05, 1.0);
                plant.truth(channel(0)).unwrap().leak_kg_per_s
            };
            near(leak(100.0), 0.0, 0.0);
            // About 100 kPa above for a second: a hundredth of the open valve.
            near(leak(280.0), 0.01 * 3e-9 * 1.185 * 381_000.0, 2e-6);
        }
        "supply_temperature" => {
            let flow = ["", "supply_temperature:amplitude_k=60,period_s=4"].map(|effect| {
                let mut plant = rig(effect, 0.0);
                run(&mut plant, -1.0, 1.0);
                run(&mut plant, 1.0, 50e-6);
                plant.truth(channel(0)).unwrap().fill_kg_per_s
            });
            near(flow[1] / flow[0], (293.15_f64 / 353.15).sqrt(), 1e-4);
        }
        "spool_stick" => {
            let mut plant = rig("spool_stick:tear_off=0.15,position=0.15", 0.0);
            for (drive, expected) in [(0.1, 0.1), (0.25, 0.15), (0.02, 0.15), (-0.1, -0.1)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "drive_crosstalk" => {
            let mut plant = rig("drive_crosstalk=0.1", 0.0);
            plant.set_drive(channel(3), 1.0).unwrap();
            run(&mut plant, 0.2, 0.001);
            near(spool(&plant), 0.3, 1e-12);
        }
        "coil_heating" => {
            let flow = ["", "coil_heating:loss=0.5,time_constant_s=1"].map(|effect| {
                let mut plant = rig(effect, 0.0);
                run(&mut plant, -1.0, 1.0);
                run(&mut plant, 1.0, 50e-6);
                plant.truth(channel(0)).unwrap().fill_kg_per_s
            });
            near(flow[1] / flow[0], 1.0 - 0.5 * (1.0 - (-1.0_f64).exp()), 1e-3);
        }
        "sensor_hysteresis" => {
            let mut plant = rig("sensor_hysteresis=3", 200.0);
            near(reading(&mut plant, 0), 200.0, 0.11);
            // Filled and vented: read too low, then too high.
            for (drive, error) in [(1.0, -3.0), (-1.0, 3.0)] {
                run(&mut plant, drive, 0.03);
                let kpa = 1e-3 * (plant.truth(channel(0)).unwrap().port_pa - AMBIENT);
                near(reading(&mut plant, 0), kpa + error, 0.11);
            }
        }
        "driver_resolution" => {
            let mut plant = rig("driver_resolution=0.1", 0.0);
            for (drive, expected) in [(0.17, 0.2), (0.04, 0.0), (-0.99, -1.0)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "regulator_backlash" => regulator_backlash(),
        _ => return false,
    }
    true
}

fn line_water() {
    let mut plant = rig("line_water:depth=0.5,gap_s=0.5,slug_s=0.5", 0.0);
    let mut blocked = 0;
    for k in 1..=200_u32 {
        run(&mut plant, if k % 2 == 0 { 1.0 } else { -1.0 }, 0.05);
        let t = plant.truth(channel(0)).unwrap();
        let open = 3e-9 * 1.0001 * 1.185 * 651_325.0;
        assert!(t.fill_kg_per_s <= 1.0001 * open);
        blocked += u32::from(k % 2 == 0 && t.fill_kg_per_s < 0.6 * open);
    }
    assert!((15..85).contains(&blocked), "{blocked} of 100");
}

fn regulator_backlash() {
    let mut plant = rig("regulator_backlash:band_kpa=60,tank_l=1,refill=3", 0.0);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for k in 0..100_u32 {
        // Fill and vent in turn: air is drawn all the time.
        run(&mut plant, if k % 2 == 0 { 1.0 } else { -1.0 }, 0.4);
        low = low.min(supply_kpa(&plant));
        high = high.max(supply_kpa(&plant));
    }
    assert!(low < 545.0 && low > 505.0, "{low}");
    assert!(high > 560.0 && high < 582.0, "{high}");
}
