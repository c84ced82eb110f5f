use crate::errors::CommandError;
use pneudrive_host::poller::BaudChoice;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{Borrowed, type_hint_identifier, type_hint_union};

/// An argument that is a line rate, or `"auto"`.
pub struct Baud(pub BaudChoice);

impl FromPyObject<'_, '_> for Baud {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = type_hint_union!(
        type_hint_identifier!("typing", "SupportsIndex"),
        type_hint_identifier!("builtins", "str")
    );

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(text) = object.extract::<&str>() {
            return match text {
                "auto" => Ok(Self(BaudChoice::Auto)),
                other => Err(CommandError::new_err(format!(
                    "baud is {other:?}; it must be a whole number of bit/s, or \"auto\""
                ))),
            };
        }
        object.extract().map(|rate| Self(BaudChoice::Rate(rate)))
    }
}
