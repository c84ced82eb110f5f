//! Commands 100 kPa to the chambers of board 0 of four, and prints what all boards measure half a
//! second later.
//!
//! ```console
//! $ cargo run --release -p pneudrive-host --example set_points -- PORT
//! ```
//!
//! PORT is a serial port, or the one that `pneudrive-sim --devices 4` prints. README.md shows what
//! `run` does, and a test compares both.
#![allow(missing_docs, reason = "the text above says what it does")]

use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::pneudrive_protocol::SensorScale;
use pneudrive_host::poller::{Poller, SetPoints};
use std::{error::Error, process::ExitCode, thread::sleep, time::Duration};

fn main() -> ExitCode {
    let Some(port) = std::env::args().nth(1) else {
        eprintln!("expected a port: /dev/ttyUSB0, or what `pneudrive-sim --devices 4` prints");
        return ExitCode::FAILURE;
    };
    run(&port).map_or_else(
        |error| {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

pub fn run(port: &str) -> Result<(), Box<dyn Error>> {
    let set_points = SetPoints::new(4); // of four boards; any thread may change them
    let bus = Bus::open(port, BusOptions::default())?;
    let poller = Poller::builder(bus).boards(0..4).rate_hz(500.0).set_points(set_points.clone()).start()?;
    set_points.set(0, [SensorScale::ORIGINAL.counts(100.0)?; 4])?;
    sleep(Duration::from_millis(500)); // the chambers of board 0 fill meanwhile
    for board in poller.latest().boards {
        if let Some(reading) = board.reading {
            println!("board {}: {:.1?} kPa", board.board, reading.kpa);
        }
    }
    poller.stop()?; // commands 0 kPa to all boards
    Ok(())
}
