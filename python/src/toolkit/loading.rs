//! `load`: a recording from a file.

use super::arguments::{self, RigArgument};
use super::expected::{Expected, Names};
use super::recording::Recording;
use super::work::{self, Watch};
use crate::errors;
use pneudrive_model::data::{self, LoadOptions};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Reads and checks a recording.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     CSV, plain or compressed with gzip or zstd, with the columns ``t_s``, ``b0_cmd0_kpa``,
///     ``b0_p0_kpa``, ``b0_u0`` and so on; or MCAP, a ROS 2 bag of the node's topics or of
///     ``pneudrive-host --record``.
/// rig : Rig or path, optional
///     With its sensors, samples at a sensor's limit are found and masked.
/// channels : sequence of str, optional
///     Channels to keep, such as ``["b0c0"]``; all by default.
/// progress : callable, optional
///     Called with (bytes read, bytes in all, what is being done).
///
/// Returns
/// -------
/// Recording
///
/// Raises
/// ------
/// DataError
///     The content cannot be understood; the message names file, row and column.
/// FileError
///     The file cannot be read.
#[pyfunction]
#[pyo3(signature = (path, rig=None, *, channels=None, progress=None))]
pub fn load(
    py: Python<'_>,
    path: PathBuf,
    rig: Option<Expected<RigArgument>>,
    channels: Option<Expected<Names>>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Recording> {
    let (rig, _) = RigArgument::resolve(rig)?;
    let channels = channels.map(arguments::channels).transpose()?;
    let work = move |watch: &Watch| {
        watch.begin("reading");
        let mut progress = |done: u64, size: u64| {
            watch.tell(done, size);
            watch.checkpoint();
        };
        let limits = |channel| rig.sensor_limits(channel);
        let options = LoadOptions {
            channels: channels.as_deref(),
            limits: Some(&limits),
            supply_kpa: rig.supply_kpa(),
            progress: Some(&mut progress),
        };
        let loaded = data::load(&path, options)?;
        watch.begin("reading events");
        Ok((loaded, data::events(&path)?))
    };
    let read: Result<_, data::DataError> = work::run(py, progress.as_ref(), work)?;
    let (loaded, events) = read.map_err(errors::recording)?;
    Ok(Recording { loaded: Arc::new(loaded), events: events.into() })
}
