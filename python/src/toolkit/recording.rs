use super::arguments::{self, RigArgument};
use super::columns;
use super::convert;
use super::expected::{Described, Expected, Names};
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, Dict, Vector};
use numpy::PyArray1;
use numpy::ndarray::Ix1;
use pneudrive_model::data::{self, ChannelId, Drive, Event, LoadOptions, Loaded, write};
use pneudrive_model::overview;
use pneudrive_model::report::{fragment, html, notes, number};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList, PySlice, PyString};
use std::path::PathBuf;
use std::sync::Arc;

/// Measured data after checking: time increases, doubtful samples are masked and named.
///
/// Made by ``load`` or ``Recording.from_columns``. Columns have the names of the file format, such
/// as ``b0_p1_kpa`` for the pressure of board 0, channel 1. Pressures are in kPa gauge, times in s,
/// angles in rad, drives from -1 (vent) to 1 (fill).
///
/// It behaves as a table whose rows are counted and whose columns are named, as a DataFrame does:
/// ``recording["b0_p1_kpa"]`` is a column, a float64 array of shape (rows,); ``in``, ``for``,
/// ``keys``, ``values``, ``items`` and ``get`` are about columns; ``len`` is the number of rows.
/// ``dict(recording)`` holds all columns. It cannot be changed; it can be pickled.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Recording {
    pub loaded: Arc<Loaded>,
    pub events: Arc<[Event]>,
}

impl Described for Py<Recording> {
    const EXPECTED: &'static str = "a Recording, such as pneudrive_py.load(\"run.csv\")";
}

impl Recording {
    /// Of data without events.
    pub fn new(loaded: Loaded) -> Self {
        Self { loaded: Arc::new(loaded), events: Arc::default() }
    }

    /// Another part or form of it.
    fn derived(&self, loaded: Result<Loaded, data::CutError>) -> PyResult<Self> {
        let loaded = loaded.map_err(errors::unusable)?;
        Ok(Self { loaded: Arc::new(loaded), events: Arc::clone(&self.events) })
    }

    fn names(&self) -> impl Iterator<Item = String> {
        let names = columns::of(self.data()).into_iter().map(|(name, _)| name);
        std::iter::once("t_s".to_owned()).chain(names)
    }

    fn page(&self) -> PyResult<String> {
        let footer = format!("pneudrive_py {} | {}", env!("CARGO_PKG_VERSION"), self.data().source.file);
        overview::recording_page(&self.loaded, &self.events, &footer).map_err(errors::unusable)
    }

    fn data(&self) -> &data::Recording {
        &self.loaded.recording
    }

    fn channel_names(&self) -> Vec<String> {
        self.data().channels.iter().map(|channel| channel.id.to_string()).collect()
    }
}

#[pymethods]
impl Recording {
    /// A recording from arrays.
    ///
    /// Parameters
    /// ----------
    /// columns : mapping from str to array_like of float, shape (rows,)
    ///     Columns of the file format: ``t_s``, ``b0_cmd0_kpa``, ``b0_p0_kpa``, ``b0_u0`` and so
    ///     on. NaN is a missing value. A pandas DataFrame does as well.
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
        rig: Option<Expected<RigArgument>>,
        channels: Option<Expected<Names>>,
        name: &str,
    ) -> PyResult<Self> {
        let (rig, _) = RigArgument::resolve(rig)?;
        let channels = channels.map(arguments::channels).transpose()?;
        let table = columns::table(columns)?;
        let name = name.to_owned();
        py.detach(move || {
            let text = columns::csv(&table)?;
            let limits = |channel| rig.sensor_limits(channel);
            let options = LoadOptions {
                channels: channels.as_deref(),
                limits: Some(&limits),
                supply_kpa: rig.supply_kpa(),
                progress: None,
            };
            let loaded = data::read(&name, text.as_bytes(), options).map_err(errors::recording)?;
            Ok(Self::new(loaded))
        })
    }

    /// A recording from what ``Poller.history`` returns: commands and pressures of all boards,
    /// cycle by cycle.
    ///
    /// Parameters
    /// ----------
    /// history : dict
    ///     ``t_s`` of shape (cycles,), ``commands_kpa`` and ``pressures_kpa`` of shape (cycles,
    ///     boards, 4), and if it is there ``supply_kpa`` of shape (cycles, boards).
    /// rig, channels
    ///     As for ``from_columns``.
    #[staticmethod]
    #[pyo3(signature = (history, *, rig=None, channels=None))]
    fn from_history(
        py: Python<'_>,
        history: &Bound<'_, PyDict>,
        rig: Option<Expected<RigArgument>>,
        channels: Option<Expected<Names>>,
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
        if let Some(supply) = history.get_item("supply_kpa")? {
            for board in 0..shape.1 {
                let of_board = supply.get_item((PySlice::full(py), board))?;
                columns.set_item(format!("b{board}_supply_kpa"), of_board)?;
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
        self.names().collect()
    }

    /// What happened while it was recorded, as the file says: dictionaries with ``t_s`` (s, as
    /// ``time_s``), ``kind`` and ``text``. Empty where the file says nothing.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::object(py, &self.events.to_vec())
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
        for (name, values) in columns::of(self.data()) {
            dict.set_item(name, convert::widened(py, values))?;
        }
        Ok(Dict::new(dict))
    }

    /// Names of the columns, as ``columns``.
    fn keys(&self) -> Vec<String> {
        self.names().collect()
    }

    /// The columns, in the order of ``keys``.
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Vec<Vector<'py>>> {
        self.names().map(|name| self.__getitem__(py, &name)).collect()
    }

    /// Names and columns.
    fn items<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Vector<'py>)>> {
        self.names().map(|name| Ok((name.clone(), self.__getitem__(py, &name)?))).collect()
    }

    /// A column, or ``default`` where there is none of this name.
    #[pyo3(signature = (column, default=None))]
    fn get<'py>(
        &self,
        py: Python<'py>,
        column: &str,
        default: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        if !self.__contains__(&PyString::new(py, column)) {
            return Ok(default);
        }
        Ok(Some(self.__getitem__(py, column)?.0.into_any()))
    }

    /// The rows of a stretch of time.
    ///
    /// Parameters
    /// ----------
    /// start_s, stop_s : float, optional
    ///     From the first row at or after ``start_s`` to the last before ``stop_s``, on the scale
    ///     of ``time_s``; by default from the first row, and to the last.
    ///
    /// Returns
    /// -------
    /// Recording
    ///     Times stay what they are; masked samples stay masked.
    ///
    /// Raises
    /// ------
    /// DataError
    ///     Fewer than two rows are left.
    #[pyo3(signature = (start_s=None, stop_s=None))]
    fn between(&self, start_s: Option<f64>, stop_s: Option<f64>) -> PyResult<Self> {
        let time_s = &self.data().time_s;
        let row = |at: f64| time_s.partition_point(|t| *t < at);
        let rows = start_s.map_or(0, row)..stop_s.map_or(time_s.len(), row);
        self.derived(self.loaded.rows(rows))
    }

    /// The recording at another rate.
    ///
    /// Parameters
    /// ----------
    /// rate_hz : float
    ///     Rows per second; they begin anew where time is missing.
    ///
    /// Returns
    /// -------
    /// Recording
    ///     Pressures, supply and angles lie on the line between their neighbours, commands and
    ///     drives hold; what is masked on either side is masked. Nothing is filtered: what is
    ///     faster than half the new rate folds over.
    ///
    /// Raises
    /// ------
    /// DataError
    ///     A rate that makes no sense for this recording.
    fn resample(&self, py: Python<'_>, rate_hz: f64) -> PyResult<Self> {
        py.detach(|| self.derived(self.loaded.resampled(rate_hz)))
    }

    /// All columns as a ``pandas.DataFrame`` whose index is the time, s (needs pandas).
    fn to_dataframe<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.tables")?.call_method1("dataframe", (slf,))
    }

    /// Pressures, set points and drives as an ``xarray.Dataset`` (needs xarray) with dimensions
    /// ``t_s`` and ``channel``, units in the attributes; ``usable`` says which pressures may be
    /// used.
    fn to_xarray<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.tables")?.call_method1("dataset", (slf,))
    }

    /// Draws set points and usable pressures (needs matplotlib): see
    /// ``pneudrive_py.plots.recording``, which takes the same keywords.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure
    #[pyo3(signature = (channels=None, **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        channels: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.plots")?.call_method("recording", (slf, channels), options)
    }

    /// The page that ``pneudrive-model show`` writes, one self-contained HTML file's content:
    /// figures of every channel, plots, events.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| self.page())
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
        let found = columns::of(self.data()).into_iter().find(|(name, _)| name == column);
        let (_, values) = found.ok_or_else(|| {
            pyo3::exceptions::PyKeyError::new_err(format!("no column {column}; see Recording.columns"))
        })?;
        Ok(convert::widened(py, values))
    }

    fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        column.extract::<String>().is_ok_and(|wanted| self.names().any(|name| name == wanted))
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.names())?.try_iter()
    }

    fn _ipython_key_completions_(&self) -> Vec<String> {
        self.keys()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        let Self { loaded, events } = slf.get();
        pickling::reduce(slf.as_any(), &(&**loaded, events.to_vec()))
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        let (loaded, events): (Loaded, Vec<Event>) = pickling::state(state)?;
        Ok(Self { loaded: Arc::new(loaded), events: events.into() })
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
        let drawn = overview::first_board(&self.loaded, &self.events);
        let content = html! {
            p { (lead.trim_matches(['<', '>'])) } (table.markup()) (notes(&self.quality())) @if let Ok(drawn) = drawn { (drawn) }
        };
        fragment(&content).into_string()
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
