use super::arguments::{self, RigArgument};
use super::convert;
use super::work::{self, Watch};
use crate::errors;
use crate::types::{Array, Dict, Vector};
use numpy::ndarray::Ix1;
use numpy::{AllowTypeChange, PyArray1, PyArrayLike1};
use pneudrive_model::data::{self, ChannelId, Drive, LoadOptions, Loaded, SensorLimits, write};
use pneudrive_model::report::{html, notes, number};
use pneudrive_model::rig;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping, PySlice};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

/// Measured data after checking: time increases, doubtful samples are masked and named.
///
/// Made by ``load`` or ``Recording.from_columns``. Columns have the names of the file format, such as ``b0_p1_kpa`` for the
/// pressure of board 0, channel 1. Pressures are in kPa gauge, times in s, angles in rad, drives from -1 (vent) to 1 (fill).
/// ``recording["b0_p1_kpa"]`` is one column, a float64 array of shape (rows,); ``len`` is the number of rows.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Recording {
    pub loaded: Arc<Loaded>,
}

impl Recording {
    fn data(&self) -> &data::Recording {
        &self.loaded.recording
    }

    fn channel_names(&self) -> Vec<String> {
        self.data().channels.iter().map(|channel| channel.id.to_string()).collect()
    }
}

/// Name and values of each column but time.
fn columns(recording: &data::Recording) -> Vec<(String, &[f32])> {
    let mut columns: Vec<(String, &[f32])> = Vec::new();
    for channel in &recording.channels {
        let id = channel.id;
        columns.extend(channel.command_kpa.as_deref().map(|values| (id.command_column(), values)));
        columns.extend(channel.pressure_kpa.as_deref().map(|values| (id.pressure_column(), values)));
        match &channel.drive {
            None => {}
            Some(Drive::Spool(u)) => columns.push((id.drive_column(), u)),
            Some(Drive::Separate { fill, vent }) => {
                let (fill_name, vent_name) = id.fill_vent_columns();
                columns.extend([(fill_name, fill.as_slice()), (vent_name, vent.as_slice())]);
            }
        }
    }
    for joint in &recording.joints {
        columns.extend(joint.qu_rad.as_deref().map(|q| (format!("b{}_qu_rad", joint.board), q)));
        columns.extend(joint.qv_rad.as_deref().map(|q| (format!("b{}_qv_rad", joint.board), q)));
    }
    columns.extend(recording.supply_kpa.as_deref().map(|values| ("supply_kpa".to_owned(), values)));
    columns
}

/// The sensors' limits, if the rig has sensors.
fn limits(rig: &rig::Rig) -> Option<SensorLimits> {
    rig.sensor.as_ref().map(rig::Sensor::limits)
}

#[pymethods]
impl Recording {
    /// A recording from arrays.
    ///
    /// Parameters
    /// ----------
    /// columns : mapping from str to array_like of float, shape (rows,)
    ///     Columns of the file format: ``t_s``, ``b0_cmd0_kpa``, ``b0_p0_kpa``, ``b0_u0`` and so on. NaN is a missing value.
    ///     A pandas DataFrame does as well.
    /// rig : Rig or path, optional
    ///     With its sensors, samples at a sensor's limit are found and masked.
    /// channels : sequence of str, optional
    ///     Channels to keep, such as ``["b0c0"]``; all by default.
    /// name : str, default "columns"
    ///     What messages call it; they count rows as a file's, the header being row 1.
    ///
    /// Returns
    /// -------
    /// Recording
    ///
    /// Raises
    /// ------
    /// DataError
    ///     No time, no channel, columns of different lengths, values outside the possible.
    #[staticmethod]
    #[pyo3(signature = (columns, *, rig=None, channels=None, name="columns"))]
    fn from_columns(
        py: Python<'_>,
        columns: &Bound<'_, PyAny>,
        rig: Option<RigArgument>,
        channels: Option<Vec<String>>,
        name: &str,
    ) -> PyResult<Self> {
        let (rig, _) = RigArgument::resolve(rig)?;
        let channels = channels.map(arguments::channels).transpose()?;
        let table = table(columns)?;
        let name = name.to_owned();
        py.detach(move || {
            let text = csv(&table)?;
            let options = LoadOptions { channels: channels.as_deref(), limits: limits(&rig), progress: None };
            let loaded = data::read(&name, text.as_bytes(), options).map_err(errors::recording)?;
            Ok(Self { loaded: Arc::new(loaded) })
        })
    }

    /// A recording from what ``Poller.history`` returns: commands and pressures of all boards, cycle by cycle.
    ///
    /// Parameters
    /// ----------
    /// history : dict
    ///     ``t_s`` of shape (cycles,), ``commands_kpa`` and ``pressures_kpa`` of shape (cycles, boards, 4).
    /// rig, channels
    ///     As for ``from_columns``.
    #[staticmethod]
    #[pyo3(signature = (history, *, rig=None, channels=None))]
    fn from_history(
        py: Python<'_>,
        history: &Bound<'_, PyDict>,
        rig: Option<RigArgument>,
        channels: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let item = |key: &str| {
            history.get_item(key)?.ok_or_else(|| errors::unusable(format!("the history has no {key:?}")))
        };
        let (commands, pressures) = (item("commands_kpa")?, item("pressures_kpa")?);
        let columns = PyDict::new(py);
        columns.set_item("t_s", item("t_s")?)?;
        let shape: (usize, usize, usize) =
            pressures.getattr("shape").and_then(|shape| shape.extract()).map_err(|error| {
                let wrong = || errors::unusable("expected pressures_kpa of shape (cycles, boards, channels)");
                errors::instead_of(py, error, wrong)
            })?;
        for board in 0..shape.1 {
            for channel in 0..shape.2 {
                columns.set_item(format!("b{board}_cmd{channel}_kpa"), series(&commands, board, channel)?)?;
                columns.set_item(format!("b{board}_p{channel}_kpa"), series(&pressures, board, channel)?)?;
            }
        }
        Self::from_columns(py, columns.as_any(), rig, channels, "history")
    }

    /// The file it was read from, or the name it was given.
    #[getter]
    fn file(&self) -> &str {
        &self.data().source.file
    }

    /// Names of the channels, such as ``"b0c1"``: board 0, channel 1.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.channel_names()
    }

    /// Names of the columns that are there, time first.
    #[getter]
    fn columns(&self) -> Vec<String> {
        let names = columns(self.data()).into_iter().map(|(name, _)| name);
        std::iter::once("t_s".to_owned()).chain(names).collect()
    }

    /// Time of each row, s; float64 array of shape (rows,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Vector<'py> {
        Array(PyArray1::from_slice(py, &self.data().time_s))
    }

    /// Time from the first row to the last, s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.data().duration_s()
    }

    /// Nominal sampling rate, Hz.
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.data().rate_hz()
    }

    /// What was noticed about the data, in sentences; masked samples among it.
    #[getter]
    fn quality(&self) -> Vec<String> {
        self.loaded.quality.sentences()
    }

    /// Which rows of a channel's pressure may be used: neither missing nor saturated nor stuck.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of bool, shape (rows,)
    fn usable<'py>(&self, py: Python<'py>, channel: &str) -> PyResult<Array<'py, bool, Ix1>> {
        let id: ChannelId = channel.parse().map_err(errors::unusable)?;
        let channel = self.data().channel(id).map_err(errors::recording)?;
        let measured = channel.pressure_kpa.is_some();
        let usable = channel.flags.iter().map(|flags| measured && flags.pressure_usable());
        Ok(Array(PyArray1::from_iter(py, usable)))
    }

    /// All columns by name, as ``pandas.DataFrame`` takes them.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Vector<'py>>> {
        let dict = PyDict::new(py);
        dict.set_item("t_s", self.time_s(py))?;
        for (name, values) in columns(self.data()) {
            dict.set_item(name, convert::widened(py, values))?;
        }
        Ok(Dict::new(dict))
    }

    /// Writes the recording to a file: ``.csv``, ``.csv.gz`` or ``.csv.zst``.
    ///
    /// Raises
    /// ------
    /// FileError
    ///     The file cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write::recording(&path, self.data()).map_err(errors::recording))
    }

    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Vector<'py>> {
        if column == "t_s" {
            return Ok(self.time_s(py));
        }
        let found = columns(self.data()).into_iter().find(|(name, _)| name == column);
        let (_, values) = found.ok_or_else(|| {
            pyo3::exceptions::PyKeyError::new_err(format!("no column {column}; see Recording.columns"))
        })?;
        Ok(convert::widened(py, values))
    }

    fn __len__(&self) -> usize {
        self.data().rows()
    }

    fn __repr__(&self) -> String {
        format!(
            "<Recording {:?}: {} rows, {:.2} s at {:.1} Hz, {}>",
            self.file(),
            self.data().rows(),
            self.duration_s(),
            self.rate_hz(),
            self.channel_names().join(", ")
        )
    }

    fn _repr_html_(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .data()
            .channels
            .iter()
            .map(|channel| {
                let range = |values: Option<&[f32]>| values.map_or_else(|| "-".to_owned(), range_text);
                let drive = match &channel.drive {
                    None => "-",
                    Some(Drive::Spool(_)) => "spool",
                    Some(Drive::Separate { .. }) => "fill and vent",
                };
                vec![
                    channel.id.to_string(),
                    drive.to_owned(),
                    range(channel.command_kpa.as_deref()),
                    range(channel.pressure_kpa.as_deref()),
                    channel.usable_samples().to_string(),
                ]
            })
            .collect();
        let head = ["channel", "drive", "command, kPa", "pressure, kPa", "usable rows"];
        let table = convert::table(&head, 2, &rows);
        let lead = self.__repr__();
        html! { p { (lead.trim_matches(['<', '>'])) } (table.markup()) (notes(&self.quality())) }
            .into_string()
    }
}

/// One channel of an array of shape (cycles, boards, channels).
fn series<'py>(array: &Bound<'py, PyAny>, board: usize, channel: usize) -> PyResult<Bound<'py, PyAny>> {
    let index = (PySlice::full(array.py()), board, channel);
    array.get_item(index).map_err(|error| errors::unusable(error.value(array.py())))
}

fn range_text(values: &[f32]) -> String {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return "-".to_owned();
    }
    format!("{} to {}", number(f64::from(low), 1), number(f64::from(high), 1))
}

/// Columns as they came from Python.
fn table(columns: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Vec<f64>)>> {
    let py = columns.py();
    let wrong = |error: PyErr| {
        let advice = "expected a mapping from column names to arrays, or a DataFrame";
        errors::instead_of(py, error, || errors::unusable(advice))
    };
    let names: Vec<String> = match columns.cast::<PyMapping>() {
        Ok(mapping) => mapping.keys().and_then(|keys| keys.extract()).map_err(wrong)?,
        // A DataFrame is no Mapping, but iterates over its columns' names as one does.
        Err(_) if columns.hasattr("columns")? => {
            columns.try_iter()?.map(|name| name?.extract()).collect::<PyResult<_>>().map_err(wrong)?
        }
        Err(error) => return Err(wrong(error.into())),
    };
    let mut table: Vec<(String, Vec<f64>)> = Vec::with_capacity(names.len());
    for name in names {
        let values = columns.get_item(&name)?;
        let array: PyArrayLike1<'_, f64, AllowTypeChange> = values.extract().map_err(|error| {
            let wrong = || errors::unusable(format!("column {name}: expected numbers of shape (rows,)"));
            errors::instead_of(py, error, wrong)
        })?;
        table.push((name, array.as_array().to_vec()));
    }
    Ok(table)
}

/// Columns as the content of a file: what is checked there is checked here.
fn csv(table: &[(String, Vec<f64>)]) -> PyResult<String> {
    let rows = table.first().map_or(0, |(_, values)| values.len());
    if let Some((name, values)) = table.iter().find(|(_, values)| values.len() != rows) {
        let first = &table[0].0;
        return Err(errors::unusable(format!(
            "column {name} has {} values and {first} has {rows}; all columns are equally long",
            values.len()
        )));
    }
    if let Some((name, _)) = table.iter().find(|(name, _)| name.contains([',', '"', '\n', '\r', '#'])) {
        return Err(errors::unusable(format!("{name:?} is no column name")));
    }
    let mut text = table.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(",");
    for row in 0..rows {
        text.push('\n');
        for (column, (_, values)) in table.iter().enumerate() {
            if column > 0 {
                text.push(',');
            }
            if values[row].is_finite() {
                // Writing to a String cannot fail.
                let _ = write!(text, "{}", values[row]);
            } else {
                // An empty line would be no row at all.
                text.push_str("na");
            }
        }
    }
    text.push('\n');
    Ok(text)
}

/// Reads and checks a recording.
///
/// Parameters
/// ----------
/// path : str or os.PathLike
///     CSV, plain or compressed with gzip or zstd, with the columns ``t_s``, ``b0_cmd0_kpa``, ``b0_p0_kpa``, ``b0_u0`` and so on;
///     or MCAP, a ROS 2 bag of the node's topics or of ``pneudrive-host --record``.
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
    rig: Option<RigArgument>,
    channels: Option<Vec<String>>,
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
        let options = LoadOptions {
            channels: channels.as_deref(),
            limits: limits(&rig),
            progress: Some(&mut progress),
        };
        data::load(&path, options)
    };
    let loaded = work::run(py, progress.as_ref(), work)?.map_err(errors::recording)?;
    Ok(Recording { loaded: Arc::new(loaded) })
}
