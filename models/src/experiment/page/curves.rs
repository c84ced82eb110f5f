//! The plots of one channel.

use crate::data::{Channel, Drive, Recording};
use crate::report::{Colour, Markup, Plot, PlotError, html};

use super::super::{ChannelComparison, ModelKind, ModelResult};

/// Length of that picture, s.
const ZOOM_S: f64 = 20.0;

/// Colours of the models, by their place in the list.
const COLOURS: [Colour; 3] = [Colour::Orange, Colour::Blue, Colour::Green];

fn colour(model: ModelKind) -> Colour {
    let place = ModelKind::ALL.iter().position(|&other| other == model).unwrap_or(0);
    COLOURS[place % COLOURS.len()]
}

/// What the plots of one channel draw from.
pub struct Curves<'a> {
    pub result: &'a ChannelComparison,
    pub channel: &'a Channel,
    pub recording: &'a Recording,
    pub from: usize,
}

impl Curves<'_> {
    fn time(&self, row: usize) -> f64 {
        self.recording.time_s[row] - self.recording.time_s[0]
    }

    fn column(&self, values: &[f32], (from, to): (usize, usize)) -> Vec<(f64, f64)> {
        (from..to).map(|row| (self.time(row), f64::from(values[row]))).collect()
    }

    /// The measured pressure where it may be used.
    fn measured(&self, rows: (usize, usize)) -> Vec<(f64, f64)> {
        let Some(values) = &self.channel.pressure_kpa else { return Vec::new() };
        let mut points = self.column(values, rows);
        for (point, flag) in points.iter_mut().zip(&self.channel.flags[rows.0..]) {
            if !flag.pressure_usable() {
                point.1 = f64::NAN;
            }
        }
        points
    }

    pub fn pressures(&self, title: &str, rows: (usize, usize)) -> Result<Markup, PlotError> {
        let mut plot = Plot::new(title, "time (s)", "pressure (kPa gauge)");
        if let Some(command) = &self.channel.command_kpa {
            plot = plot.line("command", Colour::Command, self.column(command, rows));
        }
        for model in &self.result.models {
            let Some(trace) = &model.trace else { continue };
            let points =
                (rows.0..rows.1).map(|row| (self.time(row), trace.rollout_kpa[row - trace.first_row]));
            plot = plot.line(model.model.name(), colour(model.model), points.collect());
        }
        plot.line("measured", Colour::Measured, self.measured(rows)).markup()
    }

    fn error(&self, model: &ModelResult, (from, to): (usize, usize)) -> Vec<(f64, f64)> {
        let Some(trace) = &model.trace else { return Vec::new() };
        let measured = self.measured((from, to));
        measured
            .into_iter()
            .zip(from..)
            .map(|((t, p), row)| (t, p - trace.rollout_kpa[row - trace.first_row]))
            .collect()
    }

    pub fn errors(&self, rows: (usize, usize)) -> Result<Markup, PlotError> {
        let mut plot = Plot::new("Judged part: error", "time (s)", "measured - simulated (kPa)");
        plot.include_zero = true;
        for model in self.result.models.iter().filter(|m| m.trace.is_some()) {
            plot = plot.line(model.model.name(), colour(model.model), self.error(model, rows));
        }
        plot.markup()
    }

    /// Rows around the largest error of a model.
    pub fn worst(&self, model: &ModelResult) -> (usize, usize) {
        let end = self.recording.rows();
        let errors = self.error(model, (self.from, end));
        let worst = errors
            .iter()
            .filter(|(_, e)| e.is_finite())
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .map_or(0.0, |(t, _)| *t);
        let row = |t: f64| self.recording.row_at(t).clamp(self.from, end);
        (row(worst - 0.5 * ZOOM_S), row(worst + 0.5 * ZOOM_S))
    }

    pub fn whole(&self) -> Result<Markup, PlotError> {
        let rows = (0, self.recording.rows());
        let mut plot = Plot::new("Whole recording", "time (s)", "pressure (kPa gauge)").shade(
            "fitted part",
            0.0,
            self.time(self.from),
        );
        if let Some(command) = &self.channel.command_kpa {
            plot = plot.line("command", Colour::Command, self.column(command, rows));
        }
        plot.line("measured", Colour::Measured, self.measured(rows)).markup()
    }

    pub fn drives(&self) -> Result<Markup, PlotError> {
        let rows = (0, self.recording.rows());
        let plot = Plot::new("Drive of the valve", "time (s)", "drive (1 = full)").shade(
            "fitted part",
            0.0,
            self.time(self.from),
        );
        match &self.channel.drive {
            Some(Drive::Separate { fill, vent }) => plot
                .line("fill", Colour::Blue, self.column(fill, rows))
                .line("vent", Colour::Orange, self.column(vent, rows))
                .markup(),
            Some(Drive::Spool(u)) => {
                plot.line("spool: fill above 0, vent below", Colour::Blue, self.column(u, rows)).markup()
            }
            None => Ok(html! {}),
        }
    }
}
