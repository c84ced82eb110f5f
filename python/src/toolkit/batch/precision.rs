//! In which floats results are wanted.

use crate::errors;
use numpy::{PyArrayDescr, PyArrayDescrMethods};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::{Borrowed, type_hint_identifier};

/// Floats of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    #[default]
    Double,
    Single,
}

impl<'py> FromPyObject<'_, 'py> for Precision {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = type_hint_identifier!("numpy.typing", "DTypeLike");

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        let refused =
            || errors::unusable(format!("dtype is {object:?}; it must be numpy.float64 or numpy.float32"));
        let dtype = py.import("numpy")?.call_method1("dtype", (object,));
        let dtype = dtype.map_err(|error| errors::instead_of(py, error, refused))?;
        let dtype = dtype.cast_into::<PyArrayDescr>()?;
        // Equivalent also in the order of bytes.
        if dtype.is_equiv_to(&numpy::dtype::<f64>(py)) {
            Ok(Self::Double)
        } else if dtype.is_equiv_to(&numpy::dtype::<f32>(py)) {
            Ok(Self::Single)
        } else {
            Err(refused())
        }
    }
}
