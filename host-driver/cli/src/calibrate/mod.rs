//! `calibrate`: two pressures of each channel, read from a gauge, into the rig file.

mod points;
mod settle;

use crate::args::{BusArgs, CalibrateArgs};
use crate::connect::{connect, devices};
use crate::end_reason::concluded;
use crate::failure::Failure;
use crate::find_boards;
use crate::limits;
use crate::output::{out, outln};
use crate::setup::Setup;
use crate::signals::StopSignal;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{Poller, PollerOptions, SetPoints, VENTED};
use pneudrive_protocol::CHANNELS;
use pneudrive_rig::{Sensor, with_sensor};
use points::{Point, through};
use settle::Unread;
use std::io::{BufRead, Write as _};
use std::path::Path;
use std::time::SystemTime;

/// A channel on its way.
struct Bench<'a> {
    poller: &'a Poller,
    points: &'a SetPoints,
    calibrate: &'a CalibrateArgs,
    /// What counts mean so far: nominally, so that an old calibration has no part in the new one.
    nominal: Calibration,
    setup: &'a Setup,
    stop: &'a StopSignal,
}

/// Asks for gauge readings, channel by channel, and writes each calibration as soon as it is known.
pub fn run(args: &BusArgs, calibrate: &CalibrateArgs, setup: &Setup) -> Result<(), Failure> {
    let Some(rig) = &setup.rig else {
        return Err(Failure::input(
            "calibrate writes into a rig file: pass --rig FILE.toml (`pneudrive-host init` makes one)",
        ));
    };
    let file = Path::new(rig.file());
    let devices = devices(args, 1)?;
    let channels = channels(calibrate, devices)?;
    if calibrate.low >= calibrate.high {
        return Err(Failure::input("--low must be below --high"));
    }
    let limits = limits::LimitArgs::default().limits(Some(rig))?;
    for &(board, channel) in &channels {
        let checked = limits.check(board, channel, calibrate.high);
        checked.map_err(|refused| Failure::input(format!("--high: {refused}")))?;
    }
    let stop = StopSignal::install(false)?;
    let nominal = Calibration::default();
    let mut connection = connect(args, devices, &nominal)?;
    let options = PollerOptions::for_devices(devices).limits(limits);
    let silent = find_boards::find(&mut connection.bus, &options.boards, args.wait, || stop.came())?;
    if let Some((board, error)) =
        silent.iter().find(|(board, _)| channels.iter().any(|(one, _)| one == board))
    {
        return Err(Failure::running(format!("board {board} is missing: {error}")));
    }
    let points = SetPoints::new(usize::from(devices));
    let poller = Poller::start(connection.bus, options, Box::new(points.clone()), Vec::new())?;
    let bench = Bench { poller: &poller, points: &points, calibrate, nominal, setup, stop: &stop };
    let done = channels.iter().try_for_each(|&(board, channel)| {
        let sensor = bench.channel(board, channel)?;
        points.set(usize::from(board), VENTED).map_err(Failure::running)?;
        match sensor {
            Some(sensor) => write(file, (board, channel), sensor),
            None => Ok(()),
        }
    });
    let finished = poller.stop()?;
    drop(connection.virtual_boards);
    done?;
    concluded(&finished)
}

/// The channels that were asked for: all of them, those of a board, or one.
fn channels(calibrate: &CalibrateArgs, devices: u16) -> Result<Vec<(u8, usize)>, Failure> {
    let boards = (0..=u8::MAX).take(usize::from(devices));
    let wanted = |board: &u8| calibrate.board.is_none_or(|only| only == *board);
    let channels: Vec<_> = boards
        .filter(wanted)
        .flat_map(|board| (0..CHANNELS).map(move |channel| (board, channel)))
        .filter(|(_, channel)| calibrate.channel.is_none_or(|only| usize::from(only) == *channel))
        .collect();
    if channels.is_empty() {
        return Err(Failure::input(format!(
            "--board: --devices {devices} means boards 0 to {}",
            devices - 1
        )));
    }
    Ok(channels)
}

impl Bench<'_> {
    /// The calibration of one channel; `None` if it is to be left as it is.
    fn channel(&self, board: u8, channel: usize) -> Result<Option<Sensor>, Failure> {
        let name = self.setup.channel(board, channel).map_or_else(String::new, |name| format!(" ({name})"));
        outln!("{}, channel {channel}{name}: connect the gauge", self.setup.board(board));
        loop {
            let Some(low) = self.point(board, channel, self.calibrate.low)? else { return Ok(None) };
            let Some(high) = self.point(board, channel, self.calibrate.high)? else { return Ok(None) };
            match through(low, high) {
                Ok(sensor) => return Ok(Some(sensor)),
                Err(problem) => outln!("  {problem}\n  once more:"),
            }
        }
    }

    /// Commands a pressure, waits for it, and asks what the gauge says.
    fn point(&self, board: u8, channel: usize, kpa: f64) -> Result<Option<Point>, Failure> {
        let mut command = VENTED;
        let scale = self.nominal.channel(board, channel);
        command[channel] = scale.counts(kpa).map_err(Failure::input)?;
        self.points.set(usize::from(board), command).map_err(Failure::running)?;
        let commanded = f64::from(command[channel].get());
        let settle = self.calibrate.settle;
        let reading =
            match settle::reading(self.poller, (board, channel), commanded, settle, || self.stop.came()) {
                Ok(reading) => reading,
                Err(Unread::Ended(why)) => return Err(Failure::running(why)),
                Err(Unread::Restless(why)) => {
                    outln!(
                        "  set to {} {}: {why}; the channel is left as it is",
                        self.setup.unit.number(kpa),
                        self.setup.unit.name()
                    );
                    return Ok(None);
                }
            };
        let unit = self.setup.unit;
        loop {
            out!(
                "  set to {} {}, reads {:.2} +- {:.2} counts. Gauge, {} (Enter: leave this channel): ",
                unit.number(kpa),
                unit.name(),
                reading.mean,
                reading.spread,
                unit.name()
            );
            // The question must be seen before it is answered.
            let _ = std::io::stdout().flush();
            let mut answer = String::new();
            let read = std::io::stdin().lock().read_line(&mut answer);
            match (read, answer.trim()) {
                (Err(error), _) => return Err(Failure::running(format!("standard input: {error}"))),
                (Ok(0), _) => {
                    return Err(Failure::input("standard input has ended; nothing more is calibrated"));
                }
                (Ok(_), "") => return Ok(None),
                (Ok(_), text) => match text.replace(',', ".").parse::<f64>() {
                    Ok(value) if value.is_finite() => {
                        return Ok(Some(Point { counts: reading.mean, kpa: value * unit.kpa() }));
                    }
                    _ => outln!("  \"{text}\" is no number"),
                },
            }
        }
    }
}

/// Puts the calibration into the file, which is whole at any time.
fn write(file: &Path, (board, channel): (u8, usize), sensor: Sensor) -> Result<(), Failure> {
    let name = file.display().to_string();
    let failed = |error: std::io::Error| Failure::running(format!("{name}: {error}"));
    // As it is now: it may have been edited meanwhile.
    let text = std::fs::read_to_string(file).map_err(failed)?;
    let date = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let note = format!("two points, {}", &date[..10]);
    let text = with_sensor(&name, &text, (board, channel), sensor, &note).map_err(Failure::running)?;
    // A link stays a link.
    let place = file.canonicalize().map_err(failed)?;
    let beside = place.with_extension("toml.new");
    std::fs::write(&beside, text).and_then(|()| std::fs::rename(&beside, &place)).map_err(failed)?;
    outln!("  {name}: zero_counts = {:.2}, kpa_per_count = {:.6}", sensor.zero_counts, sensor.kpa_per_count);
    Ok(())
}
