//! Plots of results in notebooks: one channel's pressures, and the errors of its models below.

use numpy::PyReadonlyArray1;
use pneudrive_model::report::{Colour, Markup, Plot, html};
use pyo3::prelude::*;
use std::fmt::Display;

/// What is drawn of one channel.
pub struct Shown<'a> {
    pub channel: &'a str,
    /// Channels that there are.
    pub channels: usize,
    pub time_s: &'a [f64],
    pub measured_kpa: &'a [f64],
    /// Name, colour and simulated pressures (kPa gauge) of each model.
    pub models: Vec<(String, Colour, Vec<f64>)>,
    /// Rows that are shaded; none where it is empty.
    pub shaded: Vec<bool>,
    pub shaded_name: &'static str,
}

/// Two rows further apart than this many of the usual distance are not joined by a line.
const GAP: f64 = 3.0;

/// The plots, or why there are none.
pub fn draw(shown: &Shown<'_>) -> Markup {
    let axis = "time, s";
    let title = format!("{}: pressures", shown.channel);
    let mut pressures = Plot::new(title, axis, "pressure, kPa gauge").line(
        "measured",
        Colour::Measured,
        points(shown.time_s, shown.measured_kpa),
    );
    let mut errors = Plot::new("Errors", axis, "measured - simulated, kPa").with_zero();
    for (name, colour, kpa) in &shown.models {
        let error_kpa: Vec<f64> = shown.measured_kpa.iter().zip(kpa).map(|(m, s)| m - s).collect();
        pressures = pressures.line(name.clone(), *colour, points(shown.time_s, kpa));
        errors = errors.line(name.clone(), *colour, points(shown.time_s, &error_kpa));
    }
    for (from, to) in stretches(shown) {
        pressures = pressures.shade(shown.shaded_name, from, to);
        errors = errors.shade(shown.shaded_name, from, to);
    }
    html! {
        @for plot in [pressures, errors] { (plot.markup().unwrap_or_else(not_drawn)) }
        @if shown.channels > 1 { p { "The first of " (shown.channels) " channels; plot() draws others." } }
    }
}

/// In the place of a plot.
pub fn not_drawn(error: impl Display) -> Markup {
    html! { p { "not drawn: " (error.to_string()) } }
}

/// The median distance of two rows, s.
fn usual_s(time_s: &[f64]) -> f64 {
    let mut distances: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Points of a line, with a break at every gap in time.
fn points(time_s: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let longest_s = GAP * usual_s(time_s);
    let mut points = Vec::with_capacity(time_s.len());
    for (k, (&time, &value)) in time_s.iter().zip(values).enumerate() {
        if k > 0 && time - time_s[k - 1] > longest_s {
            points.push((time, f64::NAN));
        }
        points.push((time, value));
    }
    points
}

/// First and last time of each stretch of shaded rows, s.
fn stretches(shown: &Shown<'_>) -> Vec<(f64, f64)> {
    let longest_s = GAP * usual_s(shown.time_s);
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    let mut last = None;
    for (&time, &inside) in shown.time_s.iter().zip(&shown.shaded) {
        match stretches.last_mut() {
            Some((_, to)) if inside && last.is_some_and(|last| time - last <= longest_s) => *to = time,
            _ if inside => stretches.push((time, time)),
            _ => {}
        }
        last = inside.then_some(time);
    }
    stretches
}

/// The plots of what `residuals(channel)` gives; rows whose `role` is `role` are shaded.
pub fn of_residuals(
    residuals: &Bound<'_, PyAny>,
    (channel, channels): (&str, usize),
    (name, colour): (&str, Colour),
    shaded: Option<(&str, &'static str)>,
) -> PyResult<Markup> {
    let column = |name: &str| -> PyResult<Vec<f64>> {
        let array: PyReadonlyArray1<'_, f64> = residuals.get_item(name)?.extract()?;
        Ok(array.as_array().to_vec())
    };
    let rows = match shaded {
        None => Vec::new(),
        Some((role, _)) => {
            let roles: Vec<String> = residuals.get_item("role")?.extract()?;
            roles.iter().map(|one| one == role).collect()
        }
    };
    Ok(draw(&Shown {
        channel,
        channels,
        time_s: &column("t_s")?,
        measured_kpa: &column("measured_kpa")?,
        models: vec![(name.to_owned(), colour, column("simulated_kpa")?)],
        shaded: rows,
        shaded_name: shaded.map_or("", |(_, name)| name),
    }))
}
