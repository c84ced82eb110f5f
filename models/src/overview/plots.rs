//! The plots of one board.

use super::channel::deviations;
use crate::data::{Channel, Drive, Event, Recording};
use crate::report::{Colour, Markup, Plot, PlotError, html};

/// A board's channels.
pub struct BoardPlots<'a> {
    pub recording: &'a Recording,
    pub board: u8,
    pub events: &'a [Event],
}

impl BoardPlots<'_> {
    fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.recording.channels.iter().filter(|channel| channel.id.board == self.board)
    }

    fn time(&self, row: usize) -> f64 {
        self.recording.time_s[row]
    }

    /// A column against time, broken where time is missing.
    fn points(&self, values: impl Iterator<Item = f64>) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for (row, value) in values.enumerate() {
            if self.recording.breaks.binary_search(&row).is_ok() {
                points.push((self.time(row), f64::NAN));
            }
            points.push((self.time(row), value));
        }
        points
    }

    fn plot(&self, title: &str, y_label: &str) -> Plot {
        let title = format!("Board {}: {title}", self.board);
        Plot::new(title, "time, s", y_label).moments(self.events.iter().map(|event| event.t_s))
    }

    /// All that there is to draw of this board.
    pub fn markup(&self) -> Result<Markup, PlotError> {
        let figures = [self.pressures(), self.deviation(), self.drives(), self.losses()];
        let figures: Vec<Markup> =
            figures.into_iter().flatten().map(|plot| plot.markup()).collect::<Result<_, _>>()?;
        Ok(html! { @for figure in &figures { (figure) } })
    }

    /// Its pressures alone.
    pub fn first(&self) -> Result<Markup, PlotError> {
        self.pressures().unwrap_or_else(|| self.plot("pressures", "pressure, kPa gauge")).markup()
    }

    fn pressures(&self) -> Option<Plot> {
        let mut plot = self.plot("pressures", "pressure, kPa gauge");
        for channel in self.channels() {
            let Some(command) = &channel.command_kpa else { continue };
            let points = self.points(command.iter().map(|kpa| f64::from(*kpa)));
            plot = plot.line("set points", Colour::Command, points);
        }
        for (channel, colour) in self.channels().zip(Colour::RESULTS.into_iter().cycle()) {
            let Some(measured) = &channel.pressure_kpa else { continue };
            let usable =
                measured.iter().zip(&channel.flags).map(|(kpa, flags)| match flags.pressure_usable() {
                    true => f64::from(*kpa),
                    false => f64::NAN,
                });
            plot = plot.line(format!("chamber {}", channel.id.channel), colour, self.points(usable));
        }
        drawable(plot)
    }

    fn deviation(&self) -> Option<Plot> {
        let mut plot = self.plot("deviation from the set points", "measured - set point, kPa").with_zero();
        for (channel, colour) in self.channels().zip(Colour::RESULTS.into_iter().cycle()) {
            let points = self.points(deviations(channel).into_iter());
            plot = plot.line(format!("chamber {}", channel.id.channel), colour, points);
        }
        drawable(plot)
    }

    fn drives(&self) -> Option<Plot> {
        let mut plot = self.plot("drives of the valves", "drive, -1 vent to 1 fill").with_zero();
        for (channel, colour) in self.channels().zip(Colour::RESULTS.into_iter().cycle()) {
            let drive: Vec<f64> = match &channel.drive {
                None => continue,
                Some(Drive::Spool(u)) => u.iter().map(|u| f64::from(*u)).collect(),
                Some(Drive::Separate { fill, vent }) => {
                    fill.iter().zip(vent).map(|(fill, vent)| f64::from(*fill) - f64::from(*vent)).collect()
                }
            };
            let points = self.points(drive.into_iter());
            plot = plot.line(format!("chamber {}", channel.id.channel), colour, points);
        }
        drawable(plot)
    }

    /// Rows without an answer, second by second; none where there were none.
    fn losses(&self) -> Option<Plot> {
        let lost = self.recording.lost_exchanges(self.board);
        let first_s = *self.recording.time_s.first()?;
        if lost.is_empty() {
            return None;
        }
        // A duration in whole seconds.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let mut counts = vec![0.0; self.recording.duration_s() as usize + 1];
        for row in lost {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let second = (self.time(row) - first_s) as usize;
            counts[second] += 1.0;
        }
        let points = counts.iter().enumerate().flat_map(|(second, count)| {
            let from = first_s + second as f64;
            [(from, *count), (from + 1.0, *count)]
        });
        let plot = self.plot("lost exchanges", "lost in each second").with_zero();
        Some(plot.line("lost", Colour::Red, points.collect()))
    }
}

/// The plot, if it shows something.
fn drawable(plot: Plot) -> Option<Plot> {
    let some = plot.series.iter().flat_map(|series| &series.points).any(|point| point.1.is_finite());
    some.then_some(plot)
}
