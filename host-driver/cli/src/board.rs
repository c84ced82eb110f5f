//! `board`: what a board says of itself, by page requests. `status` commands nothing.

use crate::args::{BoardArgs, BoardCommand, BoardStatusArgs, BusArgs};
use crate::connect::{Connection, connect, devices as devices_of};
use crate::failure::Failure;
use crate::output::{outln, print_json};
use crate::setup::Setup;
use crate::{board_parameters, board_update};
use pneudrive_host::bus::{Bus, ExchangeError, PageError};
use pneudrive_host::rig::Unit;
use pneudrive_protocol::pages::{
    About, Counter, Drives, NowState, PostMortem, SensorPart, SensorState, Temperature, Voltage,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// What a board said.
#[derive(Serialize)]
struct StatusReport {
    port: String,
    board: u8,
    chip: String,
    /// Version of its firmware.
    firmware: String,
    /// `power_up_vent`, `running`, `hold`, `vent` or `damage_vent`.
    state: &'static str,
    /// Of each channel: `regulating`, `venting`, `sensor_below_range`, `sensor_above_range` or
    /// `disabled`.
    channels: [&'static str; 4],
    /// Of each valve: -1 (vent fully) to 1 (fill fully).
    drives: [f64; 4],
    /// By name, those that its firmware has; us where the name says so, s where it says so.
    counters: BTreeMap<&'static str, u32>,
    /// What is on its I2C connector; null where its firmware does not tell.
    sensors: Option<SensorReport>,
    /// Of its chip, degrees Celsius; null where its firmware does not tell, and in its first
    /// second.
    chip_c: Option<f64>,
    /// The 5 V of its I2C connector; null without a supply sensor, which measures it.
    rail_v: Option<f64>,
    #[serde(skip)]
    tells_electronics: bool,
    /// Why its watchdog reset it last, in words; null where it has not since power-on, or nothing
    /// is known.
    post_mortem: Option<String>,
}

/// The sensors on its I2C connector.
#[derive(Serialize)]
struct SensorReport {
    /// The part, such as `ADS1115`; null without one.
    supply_part: Option<String>,
    /// `absent`, `live`, `stale` or `out_of_range`.
    supply_state: &'static str,
    /// Gauge; null where it is not live.
    supply_kpa: Option<f64>,
    /// The part, such as `BMI323`; null without one.
    imu_part: Option<String>,
    /// `absent`, `live` or `stale`.
    imu_state: &'static str,
    /// Along x, y and z of the part, gravity included; null where it is not live.
    acceleration_m_s2: Option<[f64; 3]>,
    /// About x, y and z of the part; null where it is not live.
    angular_rate_rad_s: Option<[f64; 3]>,
    /// Transfers that failed, modulo 1024.
    errors: u16,
    /// Times that the I2C lines were freed, modulo 1024.
    recoveries: u16,
}

/// A word of the post-mortem that is lost is asked for so often.
const TRIES: u32 = 100;

pub fn run(args: &BusArgs, board: &BoardArgs, setup: &Setup) -> Result<(), Failure> {
    match &board.command {
        BoardCommand::Status(status) => show(args, *status, setup),
        BoardCommand::Show(status) => board_parameters::show(args, status.board, setup),
        BoardCommand::Set(set) => board_parameters::set(args, set, setup),
        BoardCommand::Reset(status) => board_parameters::reset(args, status.board, setup),
        BoardCommand::Update(update) => board_update::update(args, update, setup),
    }
}

/// A bus with this board on it.
pub fn connect_to(args: &BusArgs, board: u8, setup: &Setup) -> Result<Connection, Failure> {
    if u16::from(board) >= args.max_devices {
        return Err(Failure::input(format!(
            "--board {board}: boards with more than a two-way address switch need --max-devices, up to 256"
        )));
    }
    // As many virtual boards as there must be, where none are asked for.
    let least = u16::from(board) + 1;
    let devices = Some(args.devices.unwrap_or(least).max(least));
    let devices = devices_of(&BusArgs { devices, ..args.clone() }, least)?;
    connect(args, devices, &setup.calibration)
}

fn show(args: &BusArgs, BoardStatusArgs { board }: BoardStatusArgs, setup: &Setup) -> Result<(), Failure> {
    let mut connection = connect_to(args, board, setup)?;
    let bus = &mut connection.bus;
    let report = ask(bus, board, args.wait).map_err(|error| Failure::running(explained(&error)))?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&report, &setup.board(board), setup.unit);
    }
    drop(connection.virtual_boards);
    Ok(())
}

/// Firmware that knows no pages keeps silent, as a board that is not there does.
pub fn explained(error: &PageError) -> String {
    match error {
        PageError::Exchange(ExchangeError::NoAnswer { .. }) => {
            format!(
                "{error}; firmware of before pages does not answer them: `ping` tells whether the board is there"
            )
        }
        PageError::Exchange(ExchangeError::OriginalFormat { .. }) => format!("{error}; it has no pages"),
        error => error.to_string(),
    }
}

/// What is lost is asked for again, for so long.
fn ask(bus: &mut Bus, board: u8, wait_s: f64) -> Result<StatusReport, PageError> {
    let until = Instant::now() + Duration::from_secs_f64(wait_s);
    let about: About = persist(until, || bus.about(board))?;
    let state: NowState = persist(until, || bus.board_state(board))?;
    let (drives, _): (Drives, u64) = persist(until, || bus.drives(board))?;
    let mut counters = BTreeMap::new();
    for counter in Counter::ALL {
        match persist(until, || bus.counter(board, counter)) {
            Ok(value) => drop(counters.insert(counter.name(), value)),
            // Firmware of before this counter.
            Err(PageError::NoSuchEntry { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    let post_mortem: Option<PostMortem> = bus.post_mortem(board, TRIES)?;
    let sensors = match ask_for_sensors(bus, board, until) {
        Ok(sensors) => Some(sensors),
        Err(PageError::NoSuchEntry { .. }) => None,
        Err(error) => return Err(error),
    };
    let electronics = match persist(until, || bus.electronics(board)) {
        Ok((electronics, _)) => Some(electronics),
        Err(PageError::NoSuchEntry { .. }) => None,
        Err(error) => return Err(error),
    };
    Ok(StatusReport {
        port: bus.line().path().display().to_string(),
        board,
        chip: about.chip.to_string(),
        firmware: about.version.map(|number| number.to_string()).join("."),
        state: state.board.name(),
        channels: state.channels.map(|channel| channel.name()),
        drives: drives.share(),
        counters,
        sensors,
        chip_c: electronics.and_then(|known| known.chip_temperature).map(Temperature::celsius),
        rail_v: electronics.and_then(|known| known.rail_voltage).map(Voltage::volts),
        tells_electronics: electronics.is_some(),
        post_mortem: post_mortem.map(|record| record.to_string()),
    })
}

fn ask_for_sensors(bus: &mut Bus, board: u8, until: Instant) -> Result<SensorReport, PageError> {
    let status = persist(until, || bus.sensors(board))?;
    let (supply, _) = persist(until, || bus.supply(board))?;
    let (acceleration, _) = persist(until, || bus.acceleration(board))?;
    let (rate, _) = persist(until, || bus.angular_rate(board))?;
    let part = |part: SensorPart| (part != SensorPart::None).then(|| part.to_string());
    let live = |state, values: Option<[f64; 3]>| values.filter(|_| state == SensorState::Live);
    Ok(SensorReport {
        supply_part: part(status.supply),
        supply_state: status.supply_state.name(),
        supply_kpa: supply.live_kpa(),
        imu_part: part(status.imu),
        imu_state: status.imu_state.name(),
        acceleration_m_s2: live(acceleration.state(), acceleration.m_per_s2()),
        angular_rate_rad_s: live(rate.state(), rate.rad_per_s()),
        errors: status.errors,
        recoveries: status.recoveries,
    })
}

/// Asks again where the exchange failed, but not where the line did, or nothing would change.
pub fn persist<T>(until: Instant, mut ask: impl FnMut() -> Result<T, PageError>) -> Result<T, PageError> {
    loop {
        match ask() {
            Err(PageError::Exchange(error))
                if !matches!(error, ExchangeError::Line(_) | ExchangeError::OriginalFormat { .. })
                    && Instant::now() < until => {}
            result => return result,
        }
    }
}

fn print(report: &StatusReport, name: &str, unit: Unit) {
    let words = |name: &str| name.replace('_', " ");
    outln!("{name}: {}, firmware {}, {}", report.chip, report.firmware, words(report.state));
    for (channel, (status, drive)) in report.channels.iter().zip(report.drives).enumerate() {
        outln!("  channel {channel}: {}, drive {drive:+.4}", words(status));
    }
    for counter in Counter::ALL {
        let name = counter.name();
        if let Some(value) = report.counters.get(name) {
            outln!("  {}: {value}", words(name));
        }
    }
    match &report.sensors {
        Some(sensors) => print_sensors(sensors, unit),
        None => outln!("  sensors on the I2C connector: its firmware does not tell"),
    }
    match report.chip_c {
        Some(chip_c) => outln!("  chip temperature: {chip_c:.1} C"),
        None if report.tells_electronics => outln!("  chip temperature: not measured so far, ask again"),
        None => {}
    }
    if let Some(rail_v) = report.rail_v {
        outln!("  5 V of the I2C connector: {rail_v:.2} V");
    }
    match &report.post_mortem {
        Some(record) => outln!("  last reset by the watchdog: {record}"),
        None => outln!("  last reset by the watchdog: none known since power-on"),
    }
}

fn print_sensors(sensors: &SensorReport, unit: Unit) {
    let state = |name: &str| name.replace('_', " ");
    match (&sensors.supply_part, sensors.supply_kpa) {
        (None, _) => outln!("  supply sensor: none"),
        (Some(part), Some(kpa)) => outln!("  supply sensor: {part}, {} {}", unit.number(kpa), unit.name()),
        (Some(part), None) => outln!("  supply sensor: {part}, {}", state(sensors.supply_state)),
    }
    match (&sensors.imu_part, sensors.acceleration_m_s2, sensors.angular_rate_rad_s) {
        (None, ..) => outln!("  IMU: none"),
        (Some(part), Some([ax, ay, az]), Some([gx, gy, gz])) => {
            outln!("  IMU: {part}, {ax:.2} {ay:.2} {az:.2} m/s^2, {gx:.3} {gy:.3} {gz:.3} rad/s");
        }
        (Some(part), ..) => outln!("  IMU: {part}, {}", state(sensors.imu_state)),
    }
    if sensors.errors > 0 || sensors.recoveries > 0 {
        outln!("  I2C errors: {}, lines freed: {} (both modulo 1024)", sensors.errors, sensors.recoveries);
    }
}
