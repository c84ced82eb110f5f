//! A trajectory that the host plays to virtual boards and records, in virtual time.

#![allow(
    clippy::unwrap_used,
    reason = "what tests are built on: what cannot be played or recorded is a failure"
)]

use std::path::Path;

use pneudrive_host::bus::{BusOptions, Counters};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{Pace, PageShare, PollerOptions, Polling, SourceStatus, VENTED};
use pneudrive_protocol::SensorScale;
use pneudrive_record::trajectory::{AtEnd, Interpolation, Trajectory};
use pneudrive_record::{PageColumns, Recorder, RecorderOptions};
use pneudrive_sim::rig::RigOptions;

use crate::virtual_bus;
use std::time::Duration;

const SCALE: SensorScale = SensorScale::ORIGINAL;
/// Rows that may wait for the disk: a recorder that is behind by 250 batches loses rows, and the
/// disk is to have no part in a test.
const MOST_WAITING: u64 = 100;

/// What is played, and how it is recorded.
#[derive(Debug, Clone, Copy)]
pub struct Take<'a> {
    /// Text of a trajectory file; it is played to its end.
    pub commands: &'a str,
    /// Rows a second, Hz.
    pub rate_hz: u32,
    /// Whether the boards are asked for their valves' drives.
    pub drives: bool,
    /// Virtual time at which the host begins, s. Before 2 s the boards vent and do not obey.
    pub begins_s: f64,
}

/// What came of it.
#[derive(Debug, Clone)]
pub struct Taken {
    /// Cycles of the host.
    pub cycles: u64,
    /// Rows in the file.
    pub rows: u64,
    /// What the host counted, board by board.
    pub counters: Vec<Counters>,
}

impl Take<'_> {
    /// Plays it to the boards of a rig and records them in `file`.
    ///
    /// # Panics
    /// The rig cannot be built, the trajectory not be read, or the file not be written.
    pub fn record(&self, rig: &RigOptions, file: &Path) -> Taken {
        let boards = u8::try_from(rig.boards).unwrap();
        let period_ns = 1_000_000_000 / u64::from(self.rate_hz);
        let options = PollerOptions::for_devices(u16::from(boards))
            .pace(Pace::every(Duration::from_nanos(period_ns)))
            .drives(self.drives.then(|| PageShare::new(1.0).unwrap()));
        let trajectory =
            Trajectory::parse("commands.csv", self.commands.as_bytes(), rig.boards, SCALE).unwrap();
        let vented = vec![VENTED; rig.boards];
        let source = trajectory.play(Interpolation::Hold, AtEnd::Stop, SCALE, vented);
        let pages = PageColumns { drives: self.drives, sensors: false };
        let how = RecorderOptions::default().pages(pages);
        let (recorder, tap) = Recorder::create_with(file, &options.boards, SCALE, &how).unwrap();
        let mut bus = virtual_bus::bus(rig, BusOptions::default());
        bus.line_mut().sleep_until_s(self.begins_s);
        let mut polling = Polling::new(bus, options, Box::new(source), vec![tap]);
        loop {
            let due = polling.next_cycle_ns();
            polling.bus_mut().line_mut().sleep_until(due);
            if polling.cycle().unwrap() == SourceStatus::Ended {
                break;
            }
            while recorder.rows_waiting() > MOST_WAITING {
                std::thread::yield_now();
            }
        }
        let counters = (0..boards).map(|board| polling.bus_mut().counters(board)).collect();
        let cycles = polling.finish().cycles;
        drop(polling);
        let rows = recorder.finish().unwrap().rows;
        Taken { cycles, rows, counters }
    }
}
