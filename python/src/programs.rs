//! The programs: an installed package has one compiled file, which does what they do.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Exit status of a program that has panicked: what was wrong is on standard error by then.
const PANICKED: u8 = 101;

/// Does what ``pneudrive-host``, ``pneudrive-sim`` or ``pneudrive-model`` does with these
/// arguments, in this process; once in it. Help and unusable arguments end the process. Returns the
/// exit status. See ``pneudrive_py.__main__``.
#[pyfunction]
#[pyo3(name = "_run_program", signature = (program, arguments))]
pub fn run_program(py: Python<'_>, program: &str, arguments: Vec<OsString>) -> PyResult<u8> {
    let main = match program {
        "pneudrive-host" => pneudrive_host_cli::main,
        #[cfg(feature = "sim")]
        "pneudrive-sim" => pneudrive_sim::cli::main,
        "pneudrive-model" => pneudrive_model_cli::main,
        _ => return Err(PyValueError::new_err(format!("this build has no program {program}"))),
    };
    let line = [OsString::from(program)].into_iter().chain(arguments).collect();
    Ok(py.detach(|| {
        let status = catch_unwind(AssertUnwindSafe(|| main(line))).unwrap_or(PANICKED);
        // A program's runtime would do it. What fails here has failed before: the reader has gone.
        let _ = std::io::stdout().flush();
        status
    }))
}
