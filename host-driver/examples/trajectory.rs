//! Follows a trajectory and records what the boards do: the file is what `pneudrive-model` reads.
//!
//! ```console
//! $ cargo run -p pneudrive-host --example trajectory -- PORT run.csv
//! ```

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::poller::{ChannelLimit, Limits, Poller, VENTED};
use pneudrive_protocol::SensorScale;
use pneudrive_record::Recorder;
use pneudrive_record::trajectory::{AtEnd, Interpolation, Trajectory};
use std::error::Error;
use std::path::Path;
use std::time::Duration;

/// Usually a file: [`Trajectory::read`].
const STEPS: &str = "t_s,b0_cmd0_kpa,b0_cmd1_kpa\n0,0,0\n2.5,150,50\n4,50,150\n5.5,0,0\n";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(port), Some(file)) = (arguments.next(), arguments.next()) else {
        return Err("expected PORT FILE.csv".into());
    };
    let rows = run(Bus::open(port, BusOptions::default())?, file.as_ref())?;
    println!("{rows} rows in {file}");
    Ok(())
}

/// Returns how many rows were recorded.
///
/// # Errors
/// The file cannot be written, or the bus thread not started.
pub fn run(bus: Bus, file: &Path) -> Result<u64, Box<dyn Error>> {
    let scale = SensorScale::ORIGINAL;
    // Faster steps than 1000 kPa/s become ramps.
    let limits = Limits::everywhere(ChannelLimit { max_kpa: 200.0, max_rate_kpa_s: 1000.0 })?;
    let trajectory = Trajectory::parse("steps", STEPS.as_bytes(), 1, scale)?;
    trajectory.check(&limits)?;
    let source = trajectory.play(Interpolation::Hold, AtEnd::Stop, scale, vec![VENTED]);
    let (recorder, tap) = Recorder::create(file, &[0], scale, false)?;
    let poller = Poller::builder(bus)
        .boards([0])
        .rate_hz(200.0)
        .limits(limits)
        .commands(source)
        .observer(tap)
        .start()?;
    while !poller.is_finished() {
        std::thread::sleep(Duration::from_millis(50));
    }
    let finished = poller.stop()?;
    if let Some(error) = finished.error {
        return Err(error.into());
    }
    Ok(recorder.finish()?.rows)
}
