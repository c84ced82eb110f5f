//! From arguments to an open bus.

use crate::args::{BusArgs, EchoArg, SessionsArg};
use crate::failure::Failure;
use pneudrive_host::Calibration;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode};
use pneudrive_protocol::{Baud, Echo};
use pneudrive_virtual::{Punctuality, VirtualBoards, VirtualOptions};
use std::time::Duration;

/// An open bus and, where it is virtual, its boards.
pub struct Connection {
    pub bus: Bus,
    /// They end when dropped: after the bus. `None` on a real port.
    pub virtual_boards: Option<VirtualBoards>,
}

/// The number of boards, checked: `default` if none is given.
pub fn devices(args: &BusArgs, default: u16) -> Result<u16, Failure> {
    let devices = args.devices.unwrap_or(default.min(args.max_devices));
    if devices == 0 || devices > args.max_devices {
        return Err(Failure::input(format!(
            "--devices {devices}: must be 1 to {}{}",
            args.max_devices,
            if devices == 0 {
                ""
            } else {
                "; boards with more than a two-way address switch need --max-devices, up to 256"
            }
        )));
    }
    Ok(devices)
}

/// Whether the port is virtual boards of our own.
pub fn is_sim(args: &BusArgs) -> bool {
    args.port.as_deref().is_some_and(pneudrive_virtual::is_sim)
}

/// The bus settings that the arguments mean.
pub fn bus_options(args: &BusArgs, devices: u16, calibration: &Calibration) -> Result<BusOptions, Failure> {
    let boards: Vec<u8> = (0..=u8::MAX).take(usize::from(devices)).collect();
    let echo = match (args.echo, u8::try_from(devices)) {
        (EchoArg::Present, _) => EchoMode::Known(Echo::Present),
        (EchoArg::Absent, _) => EchoMode::Known(Echo::Absent),
        (EchoArg::Detect, Ok(_)) => EchoMode::Detect { unused_board: u8::MAX },
        (EchoArg::Detect, Err(_)) => {
            return Err(Failure::input(
                "with 256 boards no address is left to find out whether the adapter echoes; pass --echo present or --echo absent",
            ));
        }
    };
    let baud = Baud::new(args.baud()).map_err(|error| Failure::input(format!("--baud: {error}")))?;
    let answer_allowance = match args.allowance_us {
        Some(allowance_us) => Duration::from_micros(allowance_us),
        None if is_sim(args) => BusOptions::VIRTUAL_ALLOWANCE,
        None => BusOptions::ANSWER_ALLOWANCE,
    };
    let options = BusOptions::default()
        .baud(baud)
        .answer_allowance(answer_allowance)
        .late_answer_limit(Duration::from_micros(args.late_us))
        .formats(args.frames.into())
        .sessions(args.sessions == SessionsArg::On)
        .echo(echo)
        .spin(args.spin_us);
    Ok(options.calibrated(calibration, &boards))
}

/// Opens the port for `devices` boards, starting them first if they are virtual.
pub fn connect(args: &BusArgs, devices: u16, calibration: &Calibration) -> Result<Connection, Failure> {
    open(args, devices, calibration, Punctuality::Usual)
}

/// The same, with virtual boards that are as punctual as they can be. `dated` takes the pty's round
/// trip off each request.
pub fn connect_for_measurement(args: &BusArgs, devices: u16, dated: bool) -> Result<Connection, Failure> {
    open(args, devices, &Calibration::default(), Punctuality::Best { dated })
}

fn open(
    args: &BusArgs,
    devices: u16,
    calibration: &Calibration,
    punctuality: Punctuality,
) -> Result<Connection, Failure> {
    let options = bus_options(args, devices, calibration)?;
    let port = args.port.as_deref().ok_or_else(|| {
        Failure::input(
            "no --port given; use a serial port such as /dev/ttyUSB0, or `--port sim` for virtual boards",
        )
    })?;
    if !is_sim(args) {
        return Ok(Connection { bus: Bus::open(port, options)?, virtual_boards: None });
    }
    let boards = VirtualBoards::start(
        &VirtualOptions::new(devices, options.baud)
            .timing(args.timing.into())
            .turnaround(Duration::from_micros(args.turnaround_us))
            .original(args.sim_original.clone())
            .punctuality(punctuality),
    )?;
    let bus = Bus::open(boards.path(), options)?;
    Ok(Connection { bus, virtual_boards: Some(boards) })
}
