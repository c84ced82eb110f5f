//! Recordings looked at again: their rows, and a player of them.
//!
//! To command the boards once more what a recording has, see [`trajectory`](crate::trajectory).

mod rows;

pub use rows::Rows;

use crate::Contents;
use pneudrive_host::Calibration;
use pneudrive_host::replay::{PlayOptions, Player};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::io;
use std::path::Path;

/// Shows the recording in `path` on a thread of its own. `happened` gets the events of `contents`
/// when their time comes, and what keeps rows from being read.
///
/// # Errors
/// The recording cannot be opened, has no rows, or the system has no thread to give.
pub fn play(
    path: &Path,
    contents: &Contents,
    options: PlayOptions,
    happened: impl FnMut(String) + Send + 'static,
) -> io::Result<Player> {
    let events = contents.events.iter().map(|event| (event.t_s, event.text.clone())).collect();
    let path = path.to_owned();
    Player::start(move || Rows::open(&path), options, events, happened)
}

/// What the counts of a recording meant when it was made: its `sensor` and `calibration`, and the
/// nominal sensor where it has none.
///
/// # Errors
/// Numbers that no sensor has.
pub fn calibration(contents: &Contents) -> io::Result<Calibration> {
    let of = |value: &serde_json::Value| -> Option<Result<SensorScale, String>> {
        let (zero, slope) = (value.get("zero_counts")?.as_f64()?, value.get("kpa_per_count")?.as_f64()?);
        Some(scale(zero, slope))
    };
    let refused =
        |error: String| io::Error::new(io::ErrorKind::InvalidData, format!("its calibration: {error}"));
    let usual = contents.description.get("sensor").and_then(of).transpose().map_err(refused)?;
    let usual = usual.unwrap_or(SensorScale::ORIGINAL);
    let mut calibration = Calibration::from(usual);
    let boards = contents.description.get("calibration").and_then(serde_json::Value::as_object);
    for (board, channels) in boards.into_iter().flatten() {
        let Ok(board) = board.parse() else { continue };
        let mut scales = [usual; CHANNELS];
        for (own, value) in scales.iter_mut().zip(channels.as_array().into_iter().flatten()) {
            *own = of(value).transpose().map_err(refused)?.unwrap_or(usual);
        }
        calibration = calibration.with_board(board, scales);
    }
    Ok(calibration)
}

/// A scale by its line; its span is as much of the nominal sensor's as 1023 counts hold.
fn scale(zero_counts: f64, kpa_per_count: f64) -> Result<SensorScale, String> {
    const SPAN_COUNTS: f64 = 0.8 * 1024.0;
    let nominal = SensorScale::ORIGINAL;
    if (zero_counts - nominal.zero_counts()).abs() < 1e-6
        && (kpa_per_count - nominal.kpa_per_count()).abs() < 1e-6
    {
        return Ok(nominal);
    }
    let counts = SPAN_COUNTS.min(1023.0 - zero_counts);
    SensorScale::new(zero_counts, kpa_per_count, counts * kpa_per_count).map_err(|error| error.to_string())
}
