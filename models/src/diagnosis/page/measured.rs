//! Measured against simulated on a test block, before and after, with the residual.

use crate::diagnosis::channel::Role;
use crate::diagnosis::rollout_errors::rollout_residuals;
use crate::diagnosis::run::Diagnosis;
use crate::order::descending;
use crate::report::{Colour, Markup, Plot, PlotError, html, paragraph};

/// Channels that are drawn.
const DRAWN: usize = 4;

/// One figure pair a channel: its most telling test block.
pub fn markup(diagnosis: &Diagnosis) -> Result<Markup, PlotError> {
    let mut figures = Vec::new();
    let corrected = diagnosis.extended_models.iter().any(|m| m.correction.is_some());
    let name = match (diagnosis.report.causes.is_empty(), corrected) {
        (true, false) => None,
        (false, false) => Some("causes modelled"),
        (false, true) => Some("causes and correction modelled"),
        (true, true) => Some("with the smooth correction"),
    };
    for k in worst(diagnosis) {
        let data = &diagnosis.channels[k];
        let before = rollout_residuals(data, &diagnosis.base[k]);
        let after = rollout_residuals(data, &diagnosis.extended_models[k]);
        let energy = |span: &std::ops::Range<usize>| before[span.clone()].iter().map(|r| r * r).sum::<f64>();
        let tests =
            data.blocks.iter().zip(&data.spans).filter(|(b, s)| b.role == Role::Test && !s.is_empty());
        let Some((_, span)) = tests.max_by(|a, b| energy(a.1).total_cmp(&energy(b.1))) else {
            continue;
        };
        let time = |row: usize| data.inputs.time_s[data.rows[row] as usize];
        let points =
            |f: &dyn Fn(usize) -> f64| span.clone().map(|row| (time(row), f(row))).collect::<Vec<_>>();
        let mut pressures =
            Plot::new(format!("{}: pressure in a test block", data.id), "time, s", "pressure, kPa")
                .line("measured", Colour::Measured, points(&|r| data.measured_kpa[r]))
                .line("simulated, base model", Colour::Orange, points(&|r| data.measured_kpa[r] - before[r]));
        let mut errors =
            Plot::new(format!("{}: error there", data.id), "time, s", "measured - simulated, kPa")
                .with_zero()
                .line("base model", Colour::Orange, points(&|r| before[r]));
        if let Some(name) = name {
            pressures = pressures.line(
                format!("simulated, {name}"),
                Colour::Blue,
                points(&|r| data.measured_kpa[r] - after[r]),
            );
            errors = errors.line(name, Colour::Blue, points(&|r| after[r]));
        }
        figures.push(pressures.markup()?);
        figures.push(errors.markup()?);
    }
    let which = if diagnosis.channels.len() > DRAWN {
        "the four channels with the largest error"
    } else {
        "each channel"
    };
    Ok(html! {
        (paragraph(&format!("For {which}, the stretch of test data with the largest error of the base model. Test data were used for nothing but measuring the gain. The simulation is given drives or commands and the pressure at the start of the stretch, nothing else.")))
        @for figure in figures { (figure) }
    })
}

/// The channels that are drawn: those with the largest error of the base model, in their order.
fn worst(diagnosis: &Diagnosis) -> Vec<usize> {
    let error = |k: &usize| {
        let id = diagnosis.channels[*k].id.to_string();
        diagnosis.report.baseline.channels.get(&id).map_or(0.0, |c| c.test_rmse_kpa)
    };
    let mut all: Vec<usize> = (0..diagnosis.channels.len()).collect();
    descending(&mut all, |item| error(item));
    all.truncate(DRAWN);
    all.sort_unstable();
    all
}
