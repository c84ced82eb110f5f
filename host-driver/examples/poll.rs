//! Polls boards at 500 Hz, commands 100 kPa to their chambers, and prints what they measure.
//!
//! ```console
//! $ cargo run -p pneudrive-host --example poll -- PORT [BOARDS]
//! ```
//!
//! PORT is a serial port, or the one that `pneudrive-sim --devices BOARDS` prints.

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::poller::{Finished, Poller, SetPoints};
use pneudrive_protocol::SensorScale;
use std::error::Error;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let port = arguments.next().ok_or("expected PORT [BOARDS]")?;
    let boards = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let finished = run(Bus::open(port, BusOptions::default())?, boards, Duration::from_secs(5))?;
    println!("{} of {} requests lost", finished.statistics.lost, finished.statistics.exchanges);
    Ok(())
}

/// Polls for so long. At the end 0 kPa is commanded to all boards.
///
/// # Errors
/// The bus thread cannot be started.
pub fn run(bus: Bus, boards: u8, duration: Duration) -> Result<Finished, Box<dyn Error>> {
    let set_points = SetPoints::new(boards.into());
    let poller =
        Poller::builder(bus).boards(0..boards).rate_hz(500.0).set_points(set_points.clone()).start()?;
    for board in 0..usize::from(boards) {
        set_points.set(board, [SensorScale::ORIGINAL.counts(100.0)?; 4])?;
    }
    let began = Instant::now();
    while began.elapsed() < duration && !poller.is_finished() {
        std::thread::sleep(Duration::from_millis(250));
        for board in poller.latest().boards {
            match board.reading {
                Some(reading) => println!("board {}: {:.1?} kPa", board.board, reading.kpa),
                None => println!("board {}: no answer yet", board.board),
            }
        }
    }
    Ok(poller.stop()?)
}
