//! Readings of the sensors on the boards' I2C connectors, as arrays.

use super::history::Sample;
use crate::errors::{CommandError, PneuDriveError};
use crate::types::Dict;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pneudrive_host::poller::{BoardSensors, ElectronicsReading, Motion, PageShare};
use pyo3::prelude::*;
use pyo3::types::PyDict;

const AXES: usize = 3;

/// The share of the polls that Python gave.
pub fn share(sensors: Option<f64>) -> PyResult<Option<PageShare>> {
    let checked = |share| {
        PageShare::new(share).map_err(|_| {
            CommandError::new_err(format!("sensors is {share}; it must be above 0 and at most 1, or None"))
        })
    };
    sensors.map(checked).transpose()
}

/// What one board measured: NaN where it has no such part, or that is not live.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    pub supply_kpa: f64,
    pub acceleration_m_s2: [f64; AXES],
    pub angular_rate_rad_s: [f64; AXES],
    pub chip_c: f64,
    pub rail_v: f64,
}

impl Reading {
    pub const NONE: Self = Self {
        supply_kpa: f64::NAN,
        acceleration_m_s2: [f64::NAN; AXES],
        angular_rate_rad_s: [f64::NAN; AXES],
        chip_c: f64::NAN,
        rail_v: f64::NAN,
    };

    fn of(supply_kpa: Option<f64>, motion: Option<Motion>, electronics: Option<ElectronicsReading>) -> Self {
        let electric =
            |of: fn(ElectronicsReading) -> Option<f64>| electronics.and_then(of).unwrap_or(f64::NAN);
        Self {
            supply_kpa: supply_kpa.unwrap_or(f64::NAN),
            acceleration_m_s2: motion.map_or([f64::NAN; AXES], |motion| motion.acceleration_m_s2),
            angular_rate_rad_s: motion.map_or([f64::NAN; AXES], |motion| motion.angular_rate_rad_s),
            chip_c: electric(|reading| reading.chip_c),
            rail_v: electric(|reading| reading.rail_v),
        }
    }

    /// The last one of a poller.
    pub fn last(sensors: &BoardSensors) -> Self {
        Self::of(sensors.supply.map(|supply| supply.kpa), sensors.motion, sensors.electronics)
    }

    /// What came in a cycle.
    pub fn new(sensors: &BoardSensors) -> Self {
        let supply_kpa = sensors.new_supply().map(|supply| supply.kpa);
        Self::of(supply_kpa, sensors.new_motion(), sensors.new_electronics())
    }
}

/// A reading that is one number, under its name.
type Number = (&'static str, fn(&Reading) -> f64);

/// Readings that are one number.
const NUMBERS: [Number; 3] = [
    ("supply_kpa", |reading| reading.supply_kpa),
    ("chip_c", |reading| reading.chip_c),
    ("rail_v", |reading| reading.rail_v),
];

/// The readings of all boards: shapes (boards,) and (boards, 3).
pub fn as_dict<'py>(py: Python<'py>, readings: &[Reading]) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let matrix = |rows: Vec<Vec<f64>>| {
        PyArray2::from_vec2(py, &rows).map_err(|error| PneuDriveError::new_err(error.to_string()))
    };
    let rows = |of: fn(&Reading) -> [f64; AXES]| readings.iter().map(|one| of(one).to_vec()).collect();
    let dict = PyDict::new(py);
    for (name, of) in NUMBERS {
        dict.set_item(name, PyArray1::from_iter(py, readings.iter().map(of)))?;
    }
    dict.set_item("acceleration_m_s2", matrix(rows(|one| one.acceleration_m_s2))?)?;
    dict.set_item("angular_rate_rad_s", matrix(rows(|one| one.angular_rate_rad_s))?)?;
    Ok(Dict::new(dict))
}

/// Adds what samples have of them to a history: shapes (cycles, boards) and (cycles, boards, 3).
pub fn add_to<'py>(
    py: Python<'py>,
    history: &Bound<'py, PyDict>,
    samples: &[Sample],
    boards: usize,
) -> PyResult<()> {
    for (name, of) in NUMBERS {
        let table = PyArray2::zeros(py, [samples.len(), boards], false);
        {
            let mut table = table.readwrite();
            let mut table = table.as_array_mut();
            for (n, sample) in samples.iter().enumerate() {
                for board in 0..boards {
                    table[[n, board]] = of(sample.sensors.get(board).unwrap_or(&Reading::NONE));
                }
            }
        }
        history.set_item(name, table)?;
    }
    let [acceleration, rate] = [0, 1].map(|_| PyArray3::zeros(py, [samples.len(), boards, AXES], false));
    {
        let (mut acceleration, mut rate) = (acceleration.readwrite(), rate.readwrite());
        let (mut acceleration, mut rate) = (acceleration.as_array_mut(), rate.as_array_mut());
        for (n, sample) in samples.iter().enumerate() {
            for board in 0..boards {
                let reading = sample.sensors.get(board).unwrap_or(&Reading::NONE);
                for axis in 0..AXES {
                    acceleration[[n, board, axis]] = reading.acceleration_m_s2[axis];
                    rate[[n, board, axis]] = reading.angular_rate_rad_s[axis];
                }
            }
        }
    }
    history.set_item("acceleration_m_s2", acceleration)?;
    history.set_item("angular_rate_rad_s", rate)
}
