//! Thousands of chambers at once: their pressures, and derivatives of these.

mod catalogue;
mod given;
mod gradient;
mod inputs;
mod plant;
mod precision;
mod prepared;
mod simulate;
mod sums;
mod table;

pub use catalogue::model_parameters;
pub use gradient::batch_gradient;
pub use simulate::simulate_batch;

use super::pool::Pool;
use super::work::{self, Watch};
use pneudrive_model::rollout::BatchError;
use pyo3::prelude::*;

const PA_PER_KPA: f64 = 1e3;

/// Chamber-rows below which a thread of its own costs more than the simulation.
const SMALL: usize = 20_000;

/// Does the work where Rayon's threads are those of this process; if it is `small`, without a
/// thread that can be interrupted.
fn compute<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    small: bool,
    work: impl FnOnce(&Watch) -> Result<T, BatchError> + Send,
) -> PyResult<Result<T, BatchError>> {
    if small && progress.is_none() {
        let pool = Pool::of_this_process()?;
        return Ok(py.detach(|| pool.run(|| work(&Watch::default()))));
    }
    work::run_scoped(py, progress, work)
}
