//! Values of options, each with what its user is told.

use pneudrive_host::line::Spin;
use pneudrive_host::poller::{BaudChoice, BaudChoiceError, PageShare, PageShareError, PressureFilter};
use pneudrive_host::rig::Unit;
use std::time::Duration;

/// A number, of which its user says what it must be.
pub fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

/// How many boards; the largest number that is accepted comes later.
pub fn devices(text: &str) -> Result<u16, String> {
    text.parse().map_err(|_| "expected a number of boards, 1 to 4 (up to 256 with --max-devices)".to_owned())
}

pub fn share(text: &str) -> Result<PageShare, String> {
    let share = text.parse().map_err(|_| "expected a number".to_owned())?;
    PageShare::new(share).map_err(|error: PageShareError| error.to_string())
}

pub fn unit(text: &str) -> Result<Unit, String> {
    let same = |name: &&&str| name.eq_ignore_ascii_case(text);
    let name = Unit::NAMES.iter().find(same).and_then(|name| Unit::named(name));
    name.ok_or_else(|| format!("expected {}", Unit::NAMES.join(", ")))
}

pub fn spin(text: &str) -> Result<Spin, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Spin::Auto),
        Ok(0) => Ok(Spin::Never),
        Ok(us @ 1..=1_000) => Ok(Spin::BeforeSleep(Duration::from_micros(us))),
        _ => Err("expected `auto`, or a whole number of us from 0 (never) to 1000".to_owned()),
    }
}

pub fn baud(text: &str) -> Result<BaudChoice, String> {
    text.parse().map_err(|error: BaudChoiceError| error.to_string())
}

pub fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected a number of seconds".to_owned())?;
    if seconds > 0.0 && seconds <= 1e9 {
        Ok(seconds)
    } else {
        Err("must be above 0 and at most 1e9 s".to_owned())
    }
}

pub fn filter(text: &str) -> Result<PressureFilter, String> {
    let weight: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    PressureFilter::new(weight).map_err(|error| error.to_string())
}

/// How many times as fast.
pub fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (0.01..=100.0).contains(&factor) => Ok(factor),
        _ => Err("expected a number from 0.01 to 100".to_owned()),
    }
}

/// A pressure that can be a set point, kPa gauge; limits and the sensor's range come later.
pub fn kpa(text: &str) -> Result<f64, String> {
    let kpa: f64 = text.parse().map_err(|_| "expected a number of kPa".to_owned())?;
    if kpa >= 0.0 && kpa.is_finite() { Ok(kpa) } else { Err("must be 0 kPa or more".to_owned()) }
}
