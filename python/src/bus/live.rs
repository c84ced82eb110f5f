//! Controllers that are not closed yet, so that the end of the interpreter vents their boards.

use super::ending::Signals;
use super::link::Link;
use super::session::Vented;
use crate::errors::{PortError, VentWarning};
use parking_lot::Mutex;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::Path;
use std::sync::{Arc, Weak};

/// Locked only by those who hold the interpreter's lock, as whoever forks does: so never while
/// somebody forks.
static LIVE: Mutex<Vec<Weak<Link>>> = Mutex::new(Vec::new());

fn links(_py: Python<'_>) -> Vec<Arc<Link>> {
    let mut live = LIVE.lock();
    live.retain(|link| link.strong_count() > 0);
    let all = live.iter().filter_map(Weak::upgrade);
    all.filter(|link| !link.owner().is_other_process()).collect()
}

/// Remembers `link`.
pub fn add(_py: Python<'_>, link: &Arc<Link>) {
    LIVE.lock().push(Arc::downgrade(link));
}

/// Whether a controller of this process has the port at `path`.
pub fn has(py: Python<'_>, path: &Path) -> bool {
    let same = |link: &Arc<Link>| match (link.path().canonicalize(), path.canonicalize()) {
        (Ok(theirs), Ok(wanted)) => theirs == wanted,
        _ => false,
    };
    links(py).iter().any(|link| !link.is_closed() && same(link))
}

/// Closes all controllers: boards at 0 kPa, ports free. Called when the interpreter ends; does
/// nothing in a forked child. One Ctrl-C meanwhile does not keep it from venting; the second does.
#[pyfunction]
#[pyo3(name = "_close_all")]
pub fn close_all(py: Python<'_>) -> PyResult<()> {
    let mut first_failure = Ok(());
    for link in links(py) {
        let close = || link.close("the interpreter ended", Signals::Handled);
        let closed = py.detach(close).or_else(|_| py.detach(close));
        let closed = closed.and_then(|vented| tell(py, vented.as_ref()));
        first_failure = first_failure.and(closed);
    }
    first_failure
}

/// Has the interpreter call [`close_all`] at its end.
pub fn register_atexit(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let callback = wrap_pyfunction!(close_all, module)?;
    module.py().import("atexit")?.call_method1("register", (callback,))?;
    Ok(())
}

/// Says how boards were left, where that is worth a word.
///
/// # Errors
/// `PortError` if the port failed; `VentWarning` where the user's filters make errors of warnings.
pub fn tell(py: Python<'_>, vented: Option<&Vented>) -> PyResult<()> {
    let Some(Vented { silent, failure }) = vented else { return Ok(()) };
    if !silent.is_empty() {
        let message = format!(
            "0 kPa was not confirmed by board(s) {silent:?}: they may keep their pressure until their own command timeout, and boards \
             without one until they are switched off"
        );
        PyErr::warn(py, &py.get_type::<VentWarning>(), &CString::new(message)?, 1)?;
    }
    failure.as_ref().map_or(Ok(()), |failure| Err(PortError::new_err(failure.clone())))
}

/// What the end of a `with` block raises: an exception on its way says more than that the port is
/// gone, too.
pub fn leave_block(closed: PyResult<()>, py: Python<'_>, exc_type: &Bound<'_, PyAny>) -> PyResult<()> {
    match closed {
        Err(error) if exc_type.is_none() || !error.is_instance_of::<PyException>(py) => Err(error),
        _ => Ok(()),
    }
}
