//! Sixteen chambers regulated over the bus, in virtual time.

use crate::common::{Host, MS, packet, rig};
use pneudrive_protocol::{Counts, SensorScale};

#[test]
fn sixteen_chambers_reach_300_kpa_and_return_to_atmosphere() {
    let mut bus = rig(4, &[]);
    let host = Host::default();
    let scale = SensorScale::ORIGINAL;
    let set = scale.counts(300.0).unwrap().get();
    let mut poll = |until_ms: u64, value: u16| -> Vec<[Counts; 4]> {
        let mut pressures = Vec::new();
        while bus.now_ns() < until_ms * MS {
            pressures =
                (0..4).map(|board| host.exchange(&mut bus, packet(board, value)).unwrap().values).collect();
        }
        assert_eq!(bus.counters().violations(), 0);
        pressures
    };

    poll(2_100, 102); // the power-up vent
    let before = poll(2_200, 102);
    assert!(before.iter().flatten().all(|p| p.get() < 110), "{before:?}");

    // Half way within half a second: fill time, not a jump.
    let rising = poll(2_300, set);
    assert!(rising.iter().flatten().all(|p| (150..set).contains(&p.get())), "{rising:?}");

    let there = poll(4_000, set);
    for pressure in there.iter().flatten() {
        let kpa = scale.kpa(*pressure);
        assert!((kpa - 300.0).abs() < 4.2, "{kpa:.1} kPa: worse than the original's 4.2 kPa");
    }

    let back = poll(7_000, 102);
    assert!(back.iter().flatten().all(|p| p.get() < 110), "{back:?}");
}
