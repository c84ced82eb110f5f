//! Measured against simulated on a test block, before and after, with the residual.

use crate::diagnosis::blocks::Role;
use crate::diagnosis::gain::rollout_residuals;
use crate::diagnosis::run::Diagnosis;
use crate::report::{Colour, Markup, Plot, PlotError, html, paragraph};

/// Channels that are drawn.
const DRAWN: usize = 4;

/// One figure pair a channel: its most telling test block.
pub fn markup(diagnosis: &Diagnosis) -> Result<Markup, PlotError> {
    let mut figures = Vec::new();
    let several = !diagnosis.report.causes.is_empty();
    for (k, data) in diagnosis.channels.iter().enumerate().take(DRAWN) {
        let before = rollout_residuals(data, &diagnosis.base[k]);
        let after = rollout_residuals(data, &diagnosis.stages[k].model);
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
        let mut errors = Plot::new(
            format!("{}: error there", data.id),
            "time, s",
            "measured - simulated, kPa",
        )
        .line("base model", Colour::Orange, points(&|r| before[r]));
        if several {
            pressures = pressures.line(
                "simulated, causes modelled",
                Colour::Blue,
                points(&|r| data.measured_kpa[r] - after[r]),
            );
            errors = errors.line("causes modelled", Colour::Blue, points(&|r| after[r]));
        }
        figures.push(pressures.markup()?);
        figures.push(errors.markup()?);
    }
    let note = if diagnosis.channels.len() > DRAWN { "The first four channels are drawn. " } else { "" };
    Ok(html! {
        (paragraph(&format!("{note}For each channel, the test block with the largest error of the base model. Test blocks were used for nothing but measuring the gain.")))
        @for figure in figures { (figure) }
    })
}
