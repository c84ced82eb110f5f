//! Readings of the sensors on the boards' I2C connectors, as arrays.

use super::history::Sample;
use crate::errors::{CommandError, PneuDriveError};
use crate::types::Dict;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pneudrive_host::poller::{BoardSensors, Motion, PageShare};
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
}

impl Reading {
    pub const NONE: Self = Self {
        supply_kpa: f64::NAN,
        acceleration_m_s2: [f64::NAN; AXES],
        angular_rate_rad_s: [f64::NAN; AXES],
    };

    fn of(supply_kpa: Option<f64>, motion: Option<Motion>) -> Self {
        Self {
            supply_kpa: supply_kpa.unwrap_or(f64::NAN),
            acceleration_m_s2: motion.map_or([f64::NAN; AXES], |motion| motion.acceleration_m_s2),
            angular_rate_rad_s: motion.map_or([f64::NAN; AXES], |motion| motion.angular_rate_rad_s),
        }
    }

    /// The last one of a poller.
    pub fn last(sensors: &BoardSensors) -> Self {
        Self::of(sensors.supply.map(|supply| supply.kpa), sensors.motion)
    }

    /// What came in a cycle.
    pub fn new(sensors: &BoardSensors) -> Self {
        Self::of(sensors.new_supply().map(|supply| supply.kpa), sensors.new_motion())
    }
}

/// The readings of all boards: shapes (boards,) and (boards, 3).
pub fn as_dict<'py>(py: Python<'py>, readings: &[Reading]) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let matrix = |rows: Vec<Vec<f64>>| {
        PyArray2::from_vec2(py, &rows).map_err(|error| PneuDriveError::new_err(error.to_string()))
    };
    let rows = |of: fn(&Reading) -> [f64; AXES]| readings.iter().map(|one| of(one).to_vec()).collect();
    let dict = PyDict::new(py);
    dict.set_item("supply_kpa", PyArray1::from_iter(py, readings.iter().map(|one| one.supply_kpa)))?;
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
    let supply = PyArray2::zeros(py, [samples.len(), boards], false);
    let [acceleration, rate] = [0, 1].map(|_| PyArray3::zeros(py, [samples.len(), boards, AXES], false));
    {
        let (mut supply, mut acceleration, mut rate) =
            (supply.readwrite(), acceleration.readwrite(), rate.readwrite());
        let (mut supply, mut acceleration, mut rate) =
            (supply.as_array_mut(), acceleration.as_array_mut(), rate.as_array_mut());
        for (n, sample) in samples.iter().enumerate() {
            for board in 0..boards {
                let reading = sample.sensors.get(board).unwrap_or(&Reading::NONE);
                supply[[n, board]] = reading.supply_kpa;
                for axis in 0..AXES {
                    acceleration[[n, board, axis]] = reading.acceleration_m_s2[axis];
                    rate[[n, board, axis]] = reading.angular_rate_rad_s[axis];
                }
            }
        }
    }
    history.set_item("supply_kpa", supply)?;
    history.set_item("acceleration_m_s2", acceleration)?;
    history.set_item("angular_rate_rad_s", rate)
}
