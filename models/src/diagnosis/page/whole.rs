//! The whole recording, with the blocks that measure the gain.

use crate::diagnosis::channel::Role;
use crate::diagnosis::run::Diagnosis;
use crate::report::{Colour, Markup, Plot, PlotError, html, paragraph};

/// Channels that are drawn.
const DRAWN: usize = 5;

/// One plot of the measured pressures; test blocks are shaded.
pub fn markup(diagnosis: &Diagnosis) -> Result<Markup, PlotError> {
    let mut plot = Plot::new("Measured pressures", "time, s", "pressure, kPa gauge");
    for (data, colour) in diagnosis.channels.iter().zip(Colour::RESULTS).take(DRAWN) {
        let inputs = &data.inputs;
        let rows = inputs.time_s.iter().zip(inputs.measured_pa.iter()).zip(inputs.usable.iter());
        let points = rows.map(|((time, pa), usable)| match usable {
            true => (*time, (pa - inputs.ambient_pa) * 1e-3),
            false => (*time, f64::NAN),
        });
        plot = plot.line(data.id.to_string(), colour, points.collect());
    }
    if let Some(first) = diagnosis.channels.first() {
        let time = |row: usize| first.inputs.time_s[row.min(first.inputs.rows() - 1)];
        for block in first.blocks.iter().filter(|block| block.role == Role::Test) {
            plot = plot.shade("test blocks: the gain is measured here", time(block.start), time(block.end));
        }
    }
    let more = diagnosis.channels.len().saturating_sub(DRAWN);
    Ok(html! {
        (plot.markup()?)
        @if more > 0 { (paragraph(&format!("The first {DRAWN} of {} channels.", diagnosis.channels.len()))) }
    })
}
