//! Results that can be copied, pickled and sent to other processes.

use crate::errors::DataError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// What `__reduce__` returns: a function, and the arguments that it makes the same object of.
pub type Reduced<'py> = (Bound<'py, PyAny>, (Bound<'py, PyBytes>,));

/// State with the version that wrote it: another one may keep something else.
#[derive(Serialize, Deserialize)]
struct Versioned<T> {
    version: String,
    state: T,
}

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// How `object`, whose class has a static method `_unpickle`, is made again of `state`.
pub fn reduce<'py, T: Serialize>(object: &Bound<'py, PyAny>, state: &T) -> PyResult<Reduced<'py>> {
    let versioned = Versioned { version: VERSION.to_owned(), state };
    let bytes = rmp_serde::to_vec_named(&versioned).map_err(|error| DataError::new_err(error.to_string()))?;
    Ok((object.get_type().getattr("_unpickle")?, (PyBytes::new(object.py(), &bytes),)))
}

/// The state in such bytes.
///
/// # Errors
/// `DataError` for the bytes of another version or of something else.
pub fn state<T: DeserializeOwned>(bytes: &[u8]) -> PyResult<T> {
    #[derive(Deserialize)]
    struct Written {
        version: String,
    }
    let unusable =
        |error: rmp_serde::decode::Error| DataError::new_err(format!("not a pickle of this class: {error}"));
    let written: Written = rmp_serde::from_slice(bytes).map_err(unusable)?;
    if written.version != VERSION {
        let message = format!(
            "pickled by pneudrive_py {}, this is {VERSION}: save results to files to keep them",
            written.version
        );
        return Err(DataError::new_err(message));
    }
    let versioned: Versioned<T> = rmp_serde::from_slice(bytes).map_err(unusable)?;
    Ok(versioned.state)
}
