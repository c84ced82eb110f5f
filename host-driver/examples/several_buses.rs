//! Two buses at once, each on a thread of its own: more than 16 chambers.
//!
//! ```console
//! $ cargo run -p pneudrive-host --example several_buses -- PORT PORT
//! ```

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::poller::{Poller, SetPoints};
use pneudrive_protocol::SensorScale;
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let ports: Vec<String> = std::env::args().skip(1).collect();
    if ports.is_empty() {
        return Err("expected PORT ..".into());
    }
    let buses = ports.iter().map(|port| Bus::open(port, BusOptions::default()));
    let answers = run(buses.collect::<Result<_, _>>()?, Duration::from_secs(5))?;
    for (port, answers) in ports.iter().zip(answers) {
        println!("{port}: {answers} answers of board 0");
    }
    Ok(())
}

/// Polls board 0 of each bus for so long. Returns how often each has answered.
///
/// # Errors
/// A bus thread cannot be started.
pub fn run(buses: Vec<Bus>, duration: Duration) -> Result<Vec<u64>, Box<dyn Error>> {
    let began = Instant::now();
    let mut running = Vec::new();
    for bus in buses {
        let set_points = SetPoints::new(1);
        set_points.set(0, [SensorScale::ORIGINAL.counts(80.0)?; 4])?;
        let answers = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&answers);
        let poller = Poller::builder(bus)
            .boards([0])
            .rate_hz(250.0)
            .set_points(set_points)
            .observe(move |row| {
                let fresh = row.boards.iter().filter(|board| board.fresh().is_some()).count();
                counted.fetch_add(fresh as u64, Ordering::Relaxed);
            })
            .start()?;
        running.push((poller, answers));
    }
    std::thread::sleep(duration.saturating_sub(began.elapsed()));
    let stopped = running.into_iter().map(|(poller, answers)| {
        poller.stop()?;
        Ok(answers.load(Ordering::Relaxed))
    });
    stopped.collect()
}
