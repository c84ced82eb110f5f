//! Which boards are on a port.

use crate::args::BusArgs;
use crate::connect::connect;
use crate::failure::Failure;
use crate::find_boards;
use crate::setup::Setup;
use pneudrive_host::bus::BoardFormat;
use pneudrive_protocol::{CHANNELS, Counts};
use serde::Serialize;
use std::path::Path;

/// A board that answered.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundBoard {
    /// Its number.
    pub board: u8,
    /// Which packets it answers in, which tells what it is.
    pub frames: BoardFormat,
    /// The version of its firmware and what that runs on, as its pages say; null where it has none.
    pub firmware: Option<String>,
    /// Pressures of its channels, kPa gauge; null where it calls the sensor faulty.
    pub pressures_kpa: [Option<f64>; CHANNELS],
}

impl FoundBoard {
    /// What it is, in words.
    pub fn kind(&self) -> String {
        let frames = match self.frames {
            BoardFormat::Checked => "PneuDrive firmware, checked packets",
            BoardFormat::Unchecked => "original firmware, unchecked packets, no command timeout",
            BoardFormat::Unknown => "unknown firmware",
        };
        match &self.firmware {
            Some(firmware) => format!("{frames}, {firmware}"),
            None => frames.to_owned(),
        }
    }

    /// Channels whose sensor it calls faulty, in words; empty where all are well.
    pub fn faults(&self) -> String {
        let faulty = (0..CHANNELS).filter(|&channel| self.pressures_kpa[channel].is_none());
        let faulty: Vec<_> = faulty.map(|channel| channel.to_string()).collect();
        if faulty.is_empty() {
            String::new()
        } else {
            format!("SENSOR FAULT on channel(s) {}", faulty.join(", "))
        }
    }
}

/// Asks boards 0 to `most` - 1 on `port`, by commanding 0 kPa to them.
pub fn boards(args: &BusArgs, port: &Path, most: u16, setup: &Setup) -> Result<Vec<FoundBoard>, Failure> {
    let args = BusArgs { port: Some(port.to_owned()), ..args.clone() };
    let mut connection = connect(&args, most, &setup.calibration)?;
    let bus = &mut connection.bus;
    let numbers: Vec<u8> = (0..=u8::MAX).take(usize::from(most)).collect();
    let silent = match find_boards::find(bus, &numbers, args.wait, || false) {
        Ok(silent) => silent,
        Err(_) => return Ok(Vec::new()),
    };
    let mut found = Vec::new();
    for board in numbers {
        if silent.iter().any(|(one, _)| *one == board) {
            continue;
        }
        // It has answered: what is lost now is luck.
        let answer = (0..3).find_map(|_| bus.ping(board).ok());
        let pressures_kpa = answer.map(|answer| {
            let kpa = setup.calibration.kpa(board, answer.pressures);
            let faulty = |counts: Counts| [Counts::MIN, Counts::MAX].contains(&counts);
            std::array::from_fn(|channel| (!faulty(answer.pressures[channel])).then_some(kpa[channel]))
        });
        // Of the original kind, or of before pages: no answer.
        let about = (0..3).find_map(|_| bus.about(board).ok());
        let firmware = about.map(|about| {
            let version = about.version.map(|number| number.to_string()).join(".");
            format!("version {version}, {}", about.chip)
        });
        found.push(FoundBoard {
            board,
            frames: bus.format(board),
            firmware,
            pressures_kpa: pressures_kpa.unwrap_or([None; CHANNELS]),
        });
        // A line that has failed finds no further boards.
        let _ = bus.leave(board);
    }
    drop(connection.virtual_boards);
    Ok(found)
}
