//! What the residual depends on, in plots.

use crate::diagnosis::channel::Variable;
use crate::diagnosis::discrepancy::Dependence;
use crate::diagnosis::run::Diagnosis;
use crate::diagnosis::settings::SETTINGS;
use crate::order::ascending;
use crate::report::{Align, Colour, Markup, Plot, PlotError, Table, folded, html, paragraph};

/// Points of a mean curve.
const BINS: usize = 24;
/// Lags of the autocorrelation, s.
const LAG_S: f64 = 2.0;

/// Table and plots for the base models, or for the final ones.
pub fn markup(diagnosis: &Diagnosis, base: bool) -> Result<Markup, PlotError> {
    let stages = if base { &diagnosis.base_stages } else { &diagnosis.stages };
    let found = if base { &diagnosis.symptoms } else { &diagnosis.left };
    // The channel with the largest error tells most.
    let loss = |k: &usize| {
        stages[*k].residuals.iter().map(|r| r * r).sum::<f64>() / stages[*k].residuals.len() as f64
    };
    let Some(k) = (0..stages.len()).max_by(|a, b| loss(a).total_cmp(&loss(b))) else {
        return Ok(html! {});
    };
    let (data, stage) = (&diagnosis.channels[k], &stages[k]);
    let trace = data.trace(&stage.model);
    let mut table = Table::new(&[
        ("Does the error depend on ...", Align::Left),
        ("Answer", Align::Left),
        ("part of the squared error", Align::Right),
    ]);
    let mut figures = Vec::new();
    for variable in Variable::ALL {
        let Some(values) = data.series(&trace, variable) else {
            continue;
        };
        let strongest =
            found.iter().filter(|d| d.variable == variable).min_by(|a, b| a.p_value.total_cmp(&b.p_value));
        let clear = |d: &&Dependence| d.p_value <= SETTINGS.level;
        let significant = strongest.filter(clear).is_some_and(|d| d.share >= SETTINGS.practical);
        if let Some(d) = strongest {
            let answer = match (clear(&d), significant) {
                (_, true) => "yes",
                (true, false) => "hardly",
                (false, _) => "not beyond chance",
            };
            table.row([variable.words().to_owned(), answer.to_owned(), format!("{:.0} %", 100.0 * d.share)]);
        }
        if significant || matches!(variable, Variable::Drive | Variable::Pressure | Variable::Time) {
            figures.push(against(data.id, variable, &values, &data.rows, &stage.residuals, data.noise_kpa)?);
        }
    }
    figures.push(autocorrelation(diagnosis, k, &stage.residuals)?);
    Ok(html! {
        (paragraph(&format!("The error here is what a {:.1} % wander of the supply and the start pressure of each block cannot produce. Plots show the channel with the largest error.", 100.0 * SETTINGS.supply_level)))
        (table.markup())
        (folded("Plots of the dependences", &html! { @for figure in &figures { (figure) } }))
    })
}

fn against(
    id: crate::data::ChannelId,
    variable: Variable,
    values: &[f64],
    rows: &[u32],
    residuals: &[f64],
    noise: f64,
) -> Result<Markup, PlotError> {
    let mut points: Vec<(f64, f64)> =
        rows.iter().zip(residuals).map(|(row, r)| (values[*row as usize], r * noise)).collect();
    ascending(&mut points, |item| item.0);
    let size = points.len().div_ceil(BINS).max(1);
    let means: Vec<(f64, f64)> = points
        .chunks(size)
        .map(|bin| {
            let n = bin.len() as f64;
            (bin.iter().map(|p| p.0).sum::<f64>() / n, bin.iter().map(|p| p.1).sum::<f64>() / n)
        })
        .collect();
    Plot::new(
        format!("{id}: error against {}", variable.words()),
        axis(variable),
        "measured - simulated, kPa",
    )
    .with_zero()
    .dots("samples", Colour::Command, points)
    .line("mean", Colour::Red, means)
    .markup()
}

fn axis(variable: Variable) -> &'static str {
    match variable {
        Variable::Drive => "drive, -1 vent to 1 fill",
        Variable::DriveDirection => "movement of the drive over 50 ms",
        Variable::Pressure => "pressure, kPa",
        Variable::FlowDirection => "rate of pressure, kPa/s",
        Variable::VolumeRate => "relative rate of the volume, 1/s",
        Variable::Time => "time, s",
        Variable::OthersDraw => "flow of the other channels, mm2 Pa",
        Variable::Opposite => "rate of pressure opposite, kPa/s",
        Variable::NeighbourDrive => "drive of the channel before",
    }
}

fn autocorrelation(diagnosis: &Diagnosis, k: usize, residuals: &[f64]) -> Result<Markup, PlotError> {
    let data = &diagnosis.channels[k];
    let period = data.inputs.duration_s / data.inputs.rows().max(1) as f64
        * (data.inputs.rows() as f64 / data.rows.len().max(1) as f64).max(1.0).round();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least one
    let lags = (LAG_S / period).max(1.0) as usize;
    let step = lags.div_ceil(100).max(1);
    let energy: f64 = residuals.iter().map(|r| r * r).sum();
    let points: Vec<(f64, f64)> = (1..=lags)
        .step_by(step)
        .map(|lag| {
            let product: f64 = data
                .spans
                .iter()
                .filter(|s| s.len() > lag)
                .map(|s| residuals[s.clone()].windows(lag + 1).map(|w| w[0] * w[lag]).sum::<f64>())
                .sum();
            (lag as f64 * period, product / energy)
        })
        .collect();
    Plot::new(
        format!("{}: how long the error remembers itself (0 everywhere for pure noise)", data.id),
        "lag, s",
        "correlation",
    )
    .with_zero()
    .line("autocorrelation", Colour::Blue, points)
    .markup()
}
