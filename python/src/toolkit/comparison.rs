use super::arguments::{self};
use super::convert;
use super::displays::{self, Shown};
use crate::errors;
use crate::pickling::{self, Reduced};
use crate::types::{Array, Dict, Vector};
use numpy::PyArray1;
use pneudrive_model::data::{ChannelId, Loaded, write};
use pneudrive_model::experiment::{self, ModelResult, Origin, Score, comparison_page, comparison_text};
use pneudrive_model::report::{Colour, Markup, fragment, html, significant};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Models fitted on one part of a recording and judged on the rest.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Comparison {
    kept: Kept,
}

/// A comparison, as it is kept.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Kept {
    ranking: Vec<String>,
    models: Vec<KeptModel>,
    text: String,
    html: String,
    /// Everything, as JSON.
    json: String,
}

/// One model on one channel.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct KeptModel {
    channel: ChannelId,
    model: String,
    error: Option<String>,
    rollout: Option<Score>,
    one_step: Option<Score>,
    /// Time (s), rollout and measured pressure (kPa, NaN where it may not be used).
    trace: Option<[Vec<f64>; 3]>,
}

impl Kept {
    fn of(result: experiment::Comparison, loaded: &Loaded, origin: &Origin) -> PyResult<Self> {
        let html =
            comparison_page(&result, &loaded.recording, &loaded.quality, origin).map_err(errors::unusable)?;
        let json = serde_json::to_string(&result).map_err(errors::unusable)?;
        let text = comparison_text(&result);
        let ranking = result.ranking.iter().map(|model| model.name().to_owned()).collect();
        let all = result.channels.into_iter().flat_map(|one| {
            let id = one.channel;
            one.models.into_iter().map(move |model| KeptModel::of(id, model, loaded))
        });
        let models = all.collect();
        Ok(Self { ranking, models, text, html, json })
    }
}

impl KeptModel {
    fn of(channel: ChannelId, result: ModelResult, loaded: &Loaded) -> Self {
        let trace = result.trace.map(|trace| {
            let rows = trace.first_row..trace.first_row + trace.rollout_kpa.len();
            let measured = loaded.recording.channel(channel).ok();
            let usable = |row: usize| {
                let data = measured.filter(|data| data.flags[row].pressure_usable());
                data.and_then(|data| data.pressure_kpa.as_ref()).map_or(f64::NAN, |kpa| f64::from(kpa[row]))
            };
            [loaded.recording.time_s[rows.clone()].to_vec(), trace.rollout_kpa, rows.map(usable).collect()]
        });
        Self {
            channel,
            model: result.model.name().to_owned(),
            error: result.error,
            rollout: result.rollout,
            one_step: result.one_step,
            trace,
        }
    }
}

impl Comparison {
    /// With its page, which is made at once.
    pub fn of(result: experiment::Comparison, loaded: &Loaded, origin: &Origin) -> PyResult<Self> {
        Ok(Self { kept: Kept::of(result, loaded, origin)? })
    }

    /// The times, rollout and measured pressures of one model on one channel.
    fn traced(&self, channel: &str, model: &str) -> PyResult<&[Vec<f64>; 3]> {
        let kind = arguments::model(model)?;
        let mut models = self.kept.models.iter();
        let found = models.find(|one| one.channel.to_string() == channel && one.model == kind.name());
        found.and_then(|one| one.trace.as_ref()).ok_or_else(|| {
            let why = found.and_then(|one| one.error.clone());
            let why = why.unwrap_or_else(|| "it was not compared".to_owned());
            errors::unusable(format!("no rollout of the {model} model on channel {channel}: {why}"))
        })
    }
}

impl Comparison {
    /// The judging part of the first channel, by every model, where it can be drawn.
    fn drawn(&self) -> Markup {
        let Some(channel) = self.kept.models.first().map(|one| one.channel) else { return html! {} };
        let channels: BTreeSet<_> = self.kept.models.iter().map(|one| one.channel.to_string()).collect();
        let of_channel = self.kept.models.iter().filter(|one| one.channel == channel);
        let traced: Vec<_> = of_channel.filter_map(|one| Some((one, one.trace.as_ref()?))).collect();
        let Some((_, [time_s, _, measured_kpa])) = traced.first() else { return html! {} };
        let models = traced
            .iter()
            .zip(Colour::RESULTS.into_iter().cycle())
            .map(|((one, [_, rollout_kpa, _]), colour)| (one.model.clone(), colour, rollout_kpa.clone()))
            .collect();
        let channel = channel.to_string();
        displays::draw(&Shown {
            channel: &channel,
            channels: channels.len(),
            time_s,
            measured_kpa,
            models,
            shaded: Vec::new(),
            shaded_name: "",
        })
    }
}

#[pymethods]
impl Comparison {
    /// Models, best first by the rollout error on the judging part.
    #[getter]
    fn ranking(&self) -> Vec<String> {
        self.kept.ranking.clone()
    }

    /// One row per channel and model, as ``pandas.DataFrame`` takes it: columns ``channel``,
    /// ``model``, ``rollout_rmse_kpa``, ``rollout_r2``, ``rollout_iae_kpa_s``, ``one_step_r2``,
    /// ``error`` (why there is no result, else ``None``).
    #[getter]
    fn table<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        type Number = fn(&KeptModel) -> Option<f64>;
        let numbers: [(&str, Number); 4] = [
            ("rollout_rmse_kpa", |m| m.rollout.map(|s| s.rmse_kpa)),
            ("rollout_r2", |m| m.rollout.map(|s| s.r2)),
            ("rollout_iae_kpa_s", |m| m.rollout.map(|s| s.iae_kpa_s)),
            ("one_step_r2", |m| m.one_step.map(|s| s.r2)),
        ];
        let all = || self.kept.models.iter();
        let dict = PyDict::new(py);
        dict.set_item("channel", PyList::new(py, all().map(|one| one.channel.to_string()))?)?;
        dict.set_item("model", PyList::new(py, all().map(|one| one.model.clone()))?)?;
        for (name, number) in numbers {
            let values = all().map(|one| number(one).unwrap_or(f64::NAN));
            dict.set_item(name, PyArray1::from_iter(py, values))?;
        }
        dict.set_item("error", PyList::new(py, all().map(|one| one.error.clone()))?)?;
        Ok(Dict::new(dict))
    }

    /// The rollout of one model over the judging part.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    /// model : str
    ///     ``"linear"``, ``"nonlinear"`` or ``"parametric"``.
    ///
    /// Returns
    /// -------
    /// time_s : numpy.ndarray of float64, shape (rows,)
    /// pressure_kpa : numpy.ndarray of float64, shape (rows,)
    ///     kPa gauge; NaN where nothing was simulated.
    fn trace<'py>(
        &self,
        py: Python<'py>,
        channel: &str,
        model: &str,
    ) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let [time_s, rollout_kpa, _] = self.traced(channel, model)?;
        Ok((Array(PyArray1::from_slice(py, time_s)), Array(PyArray1::from_slice(py, rollout_kpa))))
    }

    /// Measured and simulated pressures of one model on one channel, over the judging part where
    /// they can be compared.
    ///
    /// Parameters
    /// ----------
    /// channel : str
    ///     Such as ``"b0c1"``.
    /// model : str
    ///     ``"linear"``, ``"nonlinear"`` or ``"parametric"``.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_s``, ``measured_kpa``, ``simulated_kpa`` and ``residual_kpa`` (measured -
    ///     simulated): float64 arrays of shape (compared rows,).
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        channel: &str,
        model: &str,
    ) -> PyResult<Dict<'py, Vector<'py>>> {
        let [time_s, rollout_kpa, measured_kpa] = self.traced(channel, model)?;
        let compared = |row: &usize| rollout_kpa[*row].is_finite() && measured_kpa[*row].is_finite();
        let rows: Vec<usize> = (0..time_s.len()).filter(compared).collect();
        let column =
            |value: &dyn Fn(usize) -> f64| PyArray1::from_iter(py, rows.iter().map(|row| value(*row)));
        let dict = PyDict::new(py);
        dict.set_item("t_s", column(&|row| time_s[row]))?;
        dict.set_item("measured_kpa", column(&|row| measured_kpa[row]))?;
        dict.set_item("simulated_kpa", column(&|row| rollout_kpa[row]))?;
        dict.set_item("residual_kpa", column(&|row| measured_kpa[row] - rollout_kpa[row]))?;
        Ok(Dict::new(dict))
    }

    /// Draws the measured pressures of the judging part and every model's (needs matplotlib): see
    /// ``pneudrive_py.plots.comparison``, which takes the same keywords.
    ///
    /// Returns
    /// -------
    /// matplotlib.figure.Figure
    #[pyo3(signature = (channel=None, **options))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        channel: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("pneudrive_py.plots")?.call_method("comparison", (slf, channel), options)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        pickling::reduce(slf.as_any(), &slf.get().kept)
    }

    #[staticmethod]
    fn _unpickle(state: &[u8]) -> PyResult<Self> {
        Ok(Self { kept: pickling::state(state)? })
    }

    /// Everything, as dictionaries.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        convert::parsed(py, &self.kept.json)
    }

    /// The page with tables and plots, one self-contained HTML file's content.
    fn html(&self) -> String {
        self.kept.html.clone()
    }

    /// Writes the page to a file.
    ///
    /// Raises
    /// ------
    /// FileError
    ///     It cannot be written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| write::text_atomically(&path, &self.kept.html).map_err(errors::recording))
    }

    fn __repr__(&self) -> String {
        self.kept.text.clone()
    }

    fn _repr_html_(&self) -> String {
        let r2 =
            |score: Option<&Score>| score.map_or_else(|| "-".to_owned(), |score| significant(score.r2, 3));
        let line = |one: &KeptModel| {
            vec![
                one.channel.to_string(),
                one.model.clone(),
                one.error.clone().unwrap_or_else(|| convert::rmse(one.rollout.as_ref())),
                r2(one.rollout.as_ref()),
                r2(one.one_step.as_ref()),
            ]
        };
        let rows: Vec<Vec<String>> = self.kept.models.iter().map(line).collect();
        let head = ["channel", "model", "rollout RMSE, kPa", "rollout R2", "one-step R2"];
        let content = html! { (convert::table(&head, 2, &rows).markup()) (self.drawn()) };
        fragment(&content).into_string()
    }
}
