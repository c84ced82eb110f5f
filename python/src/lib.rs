//! Python bindings: the bus and the modelling toolkit, NumPy arrays in and out.
//!
//! Nothing is decided here. Each file turns one part of the Rust libraries into what a Python user
//! expects: arrays with stated shapes and units, keyword arguments, exceptions of
//! `pneudrive_py.exceptions`, context managers. Whatever takes longer than a microsecond runs
//! without the interpreter's lock.

mod arrays;
mod bus;
mod errors;
mod pickling;
mod programs;
mod toolkit;
mod types;

use pyo3::prelude::*;

/// The compiled part of `pneudrive_py`; import that.
#[pymodule]
mod _pneudrive {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::bus::{Poller, PressureController};

    #[pymodule_export]
    use crate::toolkit::{
        Comparison, Diagnosis, ExtendedModel, Fit, Parameters, Recording, Rig, Simulation, Stepper,
        batch_gradient, compare, diagnose, effects, fit, load, model_parameters, simulate, simulate_batch,
    };

    #[pymodule_export]
    use crate::programs::run_program;

    #[pymodule_export]
    use crate::toolkit::record_data_set;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::toolkit::imported();
        crate::bus::register_atexit(module)
    }

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
