use super::super::arguments;
use super::given::setup;
use crate::errors;
use crate::types::Dict;
use pneudrive_model::experiment::{DriveKind, subject};
use pneudrive_model::model::FlowForm;
use pneudrive_model::rig::Rig;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// One parameter's description.
type Parameter<'py> = Dict<'py, Bound<'py, PyAny>>;

/// The parameters of a model, in the order that ``simulate_batch`` takes them.
///
/// Parameters
/// ----------
/// model : {"nonlinear", "parametric", "linear"}
/// drive : {"spool", "separate"}, default "spool"
///     Kind of valve.
///
/// Returns
/// -------
/// list of dict
///     ``name``, ``unit``, ``lower``, ``nominal``, ``upper``, ``meaning``.
#[pyfunction]
#[pyo3(signature = (model, drive="spool"))]
pub fn model_parameters<'py>(py: Python<'py>, model: &str, drive: &str) -> PyResult<Vec<Parameter<'py>>> {
    let separate = arguments::drive(drive)? == DriveKind::Separate;
    let setup = setup(arguments::model(model)?, false, separate);
    let subject = subject(setup, &Rig::default(), FlowForm::Iso6358).map_err(errors::unusable)?;
    let describe = |parameter: pneudrive_model::model::Parameter| {
        let dict = PyDict::new(py);
        dict.set_item("name", parameter.name)?;
        dict.set_item("unit", parameter.unit)?;
        dict.set_item("lower", parameter.lower)?;
        dict.set_item("nominal", parameter.nominal)?;
        dict.set_item("upper", parameter.upper)?;
        dict.set_item("meaning", parameter.meaning)?;
        Ok(Dict::new(dict))
    };
    subject.parameters().into_iter().map(describe).collect()
}
