//! Arrays of real numbers from whatever NumPy makes one of, and shapes as Python writes them.

use crate::errors;
use numpy::{PyArrayDescrMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

/// An array of float64 that nobody else changes.
pub type Floats<'py> = PyReadonlyArrayDyn<'py, f64>;

/// `object` as an array of float64; an array that is one already is not copied. Truth values,
/// complex numbers and texts are no pressures, although NumPy would make some of them.
///
/// # Errors
/// The exception that `wrong` makes of what came instead; Ctrl-C and exits stay what they are.
pub fn floats<'py>(object: &Bound<'py, PyAny>, wrong: impl Fn(&str) -> PyErr) -> PyResult<Floats<'py>> {
    if let Ok(array) = object.extract() {
        return Ok(array);
    }
    let py = object.py();
    let numpy = py.import("numpy")?;
    let refused = |error| errors::instead_of(py, error, || wrong(&description(object)));
    let array = numpy.call_method1("asarray", (object,)).map_err(refused)?;
    let kind = array.cast::<PyUntypedArray>().map_or(b'O', |array| array.dtype().kind());
    let is_one_object = array.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() == 0);
    match kind {
        b'O' if is_one_object => return Err(wrong(&description(object))),
        b'i' | b'u' | b'f' | b'O' => {}
        b'b' => return Err(wrong("truth values")),
        b'c' => return Err(wrong("complex numbers")),
        b'U' | b'S' if !is_one_object => return Err(wrong("texts")),
        _ => return Err(wrong(&description(object))),
    }
    let options = [("dtype", "float64")].into_py_dict(py)?;
    let array = numpy.call_method("asarray", (array,), Some(&options)).map_err(refused)?;
    array.extract().map_err(refused)
}

/// What `object` is, for messages: its type, and its shape if it has one.
fn description(object: &Bound<'_, PyAny>) -> String {
    let class = object.get_type().name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
    match object.getattr("shape").and_then(|shape| shape.str()) {
        Ok(shape) => format!("{class} of shape {shape}"),
        Err(_) => class,
    }
}

/// A shape as NumPy writes it: `(2, 4)`, `(4,)`, `()`.
pub fn shape_text(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        several => {
            let lengths: Vec<String> = several.iter().map(usize::to_string).collect();
            format!("({})", lengths.join(", "))
        }
    }
}
