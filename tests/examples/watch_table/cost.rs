//! What watching 16 chambers at 1 kHz takes.

use std::time::Instant;

use pneudrive_model::watch::WatchSettings;

use super::rig::{Kind, STEP_NS};

/// Seconds that are recorded and watched.
const SECONDS: f64 = 30.0;

/// Prints the share of a core, with drives recorded and without.
pub fn run() {
    for drive in [true, false] {
        let kind = Kind { channels: 16, rate_hz: 1000.0, drive, step_ns: STEP_NS };
        let folder = tempfile::tempdir().unwrap();
        // Sixteen times the same valve: what it costs does not depend on the numbers.
        let mut model =
            Kind { channels: 1, rate_hz: 100.0, drive, step_ns: STEP_NS }.calibrated(1, folder.path());
        let valve = model.channels["b0c0"].clone();
        for k in 0..16 {
            model.channels.insert(format!("b{}c{}", k / 4, k % 4), valve.clone());
        }
        let rows: Vec<_> = kind.rows(1, SECONDS, &[]).map(|row| kind.sample(&row)).collect();
        let mut watcher = kind.watcher(&model, WatchSettings::default());
        let began = Instant::now();
        for row in rows {
            watcher.take(row, &mut |_| {});
        }
        let took_s = began.elapsed().as_secs_f64();
        println!(
            "16 chambers at 1 kHz, drives {}: {:.1} % of a core, {:.1} us a row",
            if drive { "recorded" } else { "not recorded" },
            100.0 * took_s / SECONDS,
            1e3 * took_s / SECONDS
        );
    }
}
