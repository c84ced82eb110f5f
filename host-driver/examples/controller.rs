//! A controller of one's own around the boards' loops: 500 times a second it looks at the newest
//! pressures and sets new set points. Here it keeps the mean of two opposed chambers at 100 kPa and
//! brings their difference to 40 kPa.
//!
//! ```console
//! $ cargo run -p pneudrive-host --example controller -- PORT
//! ```
//!
//! Where the controller gets stuck, the boards are vented after 200 ms.

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{Poller, SetPoints};
use pneudrive_protocol::SensorScale;
use std::error::Error;
use std::time::{Duration, Instant};

const RATE_HZ: f64 = 500.0;
const MEAN_KPA: f64 = 100.0;
const DIFFERENCE_KPA: f64 = 40.0;
/// Of the integrator, 1/s.
const GAIN: f64 = 2.0;
/// An older reading is not acted on.
const OLDEST: Duration = Duration::from_millis(100);

fn main() -> Result<(), Box<dyn Error>> {
    let port = std::env::args().nth(1).ok_or("expected PORT")?;
    let difference_kpa = run(Bus::open(port, BusOptions::default())?, Duration::from_secs(6))?;
    println!("{difference_kpa:.1} kPa between chambers 0 and 1");
    Ok(())
}

/// Controls board 0 for so long. Returns the last difference, kPa.
///
/// # Errors
/// The bus thread cannot be started.
pub fn run(bus: Bus, duration: Duration) -> Result<f64, Box<dyn Error>> {
    let scale = SensorScale::ORIGINAL;
    let set_points = SetPoints::new(1).vent_after(Duration::from_millis(200));
    let poller = Poller::builder(bus).boards([0]).rate_hz(RATE_HZ).set_points(set_points.clone()).start()?;
    let period = Duration::from_secs_f64(1.0 / RATE_HZ);
    let (began, mut due) = (Instant::now(), Instant::now());
    let (mut half_kpa, mut difference_kpa) = (0.0, 0.0);
    while began.elapsed() < duration && !poller.is_finished() {
        if let Some(reading) = poller.latest().reading(0, Clock.now_ns(), OLDEST) {
            difference_kpa = reading.kpa[0] - reading.kpa[1];
            half_kpa += GAIN * (DIFFERENCE_KPA - difference_kpa) / 2.0 * period.as_secs_f64();
            half_kpa = f64::clamp(half_kpa, -MEAN_KPA, MEAN_KPA);
            let [high, low] = [scale.counts(MEAN_KPA + half_kpa)?, scale.counts(MEAN_KPA - half_kpa)?];
            let vented = scale.counts(0.0)?;
            set_points.set(0, [high, low, vented, vented])?;
        } else {
            set_points.renew();
        }
        due += period;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    poller.stop()?;
    Ok(difference_kpa)
}
