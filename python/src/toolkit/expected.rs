//! Arguments of several types, refused in Python's words.

use crate::errors;
use pyo3::exceptions::PyTypeError;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{Borrowed, FromPyObject};

/// An argument of type `T`; what it is not is said as [`Described`] says it, and not in the words
/// of the bindings.
pub struct Expected<T>(pub T);

/// What a user has to pass.
pub trait Described {
    /// As it completes "expected ..".
    const EXPECTED: &'static str;
}

impl<'a, 'py, T: FromPyObject<'a, 'py> + Described> FromPyObject<'a, 'py> for Expected<T> {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = T::INPUT_TYPE;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        T::extract(object).map(Self).map_err(|error| {
            let refused = || {
                let class = object.get_type();
                let name = class.name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
                PyTypeError::new_err(format!("expected {}, got {name}", T::EXPECTED))
            };
            errors::instead_of(py, error.into(), refused)
        })
    }
}

/// Names of channels or models.
#[derive(FromPyObject)]
#[pyo3(transparent)]
pub struct Names(pub Vec<String>);

impl Described for Names {
    const EXPECTED: &'static str = "a sequence of str, such as [\"b0c0\"]";
}
