use super::super::arguments;
use super::super::expected::Expected;
use super::plant::{ModelArgument, Plant, Wanted};
use crate::types::Dict;
use pneudrive_model::experiment::DriveKind;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// One parameter's description.
type Description<'py> = Dict<'py, Bound<'py, PyAny>>;

/// The parameters of a model, in the order that ``simulate_batch`` takes them.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
/// drive : {"spool", "separate"}, default "spool"
///     Kind of valve, of a model by its name.
/// channel : str, optional
///     Of a calibrated model; by default its only one.
///
/// Returns
/// -------
/// list of dict
///     ``name``, ``unit``, ``lower``, ``nominal``, ``upper``, ``meaning``; of a calibrated model
///     ``value``, too. An effect's are called as in ``valve_lag.time_constant``.
#[pyfunction]
#[pyo3(signature = (model, drive="spool", *, channel=None))]
pub fn model_parameters<'py>(
    py: Python<'py>,
    model: Expected<ModelArgument>,
    drive: &str,
    channel: Option<&str>,
) -> PyResult<Vec<Description<'py>>> {
    let separate = arguments::drive(drive)? == DriveKind::Separate;
    let plant =
        Plant::new(model.0, Wanted { channel, rig: None, controller: None, substeps: None, separate })?;
    let describe = |(k, parameter): (usize, pneudrive_model::model::Parameter)| {
        let dict = PyDict::new(py);
        dict.set_item("name", parameter.name)?;
        dict.set_item("unit", parameter.unit)?;
        dict.set_item("lower", parameter.lower)?;
        dict.set_item("nominal", parameter.nominal)?;
        dict.set_item("upper", parameter.upper)?;
        dict.set_item("meaning", parameter.meaning)?;
        if let Some(calibrated) = &plant.calibrated {
            dict.set_item("value", calibrated[k])?;
        }
        Ok(Dict::new(dict))
    };
    plant.parameters().into_iter().enumerate().map(describe).collect()
}
