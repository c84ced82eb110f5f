//! `--preview`: what a trajectory will command, as pictures made of characters, without a board.

use crate::output::outln;
use crate::setup::Setup;
use crate::sources::Source;
use pneudrive_host::poller::{BoardCommand, Limits, SourceStatus, VENTED};
use pneudrive_protocol::CHANNELS;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Widget};

/// Moments that are drawn: several for each dot, so that no level is passed over that lasts a
/// thousandth of the time.
const MOMENTS: usize = 4000;
const HEIGHT: u16 = 8;
/// Where the width of the terminal is not known.
const USUAL_WIDTH: u16 = 80;
const WIDEST: u16 = 120;

/// A channel and what it will be commanded, kPa.
struct Plot {
    places: Vec<(u8, usize)>,
    kpa: Vec<f64>,
    limit_kpa: f64,
    limit_rate_kpa_s: f64,
}

/// Draws each channel that is commanded something; channels that do the same share a picture.
pub fn print(mut source: Source, boards: usize, setup: &Setup, limits: &Limits) {
    let seconds = source.ends_s.unwrap_or(0.0);
    let (times, commands) = sampled(&mut source, boards, seconds);
    let unit = setup.unit;
    let plots = plots(&commands, boards, setup, limits);
    let width = ratatui::crossterm::terminal::size().map_or(USUAL_WIDTH, |(columns, _)| columns);
    outln!("{seconds:.1} s, nothing has been commanded:");
    for plot in &plots {
        let (low, high) = range(&plot.kpa);
        let limit = if plot.limit_kpa.is_finite() {
            format!(", limit {}", unit.number(plot.limit_kpa))
        } else {
            String::new()
        };
        let rate = if plot.limit_rate_kpa_s.is_finite() {
            format!(
                "; faster changes than {} {}/s are ramped",
                unit.number(plot.limit_rate_kpa_s),
                unit.name()
            )
        } else {
            String::new()
        };
        outln!("{}", names(&plot.places, setup));
        outln!("  {} to {} {}{limit}{rate}", unit.number(low), unit.number(high), unit.name());
        if high > low {
            let scaled: Vec<_> = times.iter().zip(&plot.kpa).map(|(&t, kpa)| (t, kpa / unit.kpa())).collect();
            let ends = [unit.number(0.0), unit.number(high)];
            picture(&scaled, seconds, high / unit.kpa(), ends, width.clamp(40, WIDEST))
                .iter()
                .for_each(|line| outln!("{line}"));
        }
    }
}

/// What is commanded at each of [`MOMENTS`] moments.
fn sampled(source: &mut Source, boards: usize, seconds: f64) -> (Vec<f64>, Vec<Vec<BoardCommand>>) {
    let (mut times, mut commands) = (Vec::new(), Vec::new());
    for moment in 0..=MOMENTS {
        let t_s = seconds * moment as f64 / MOMENTS as f64;
        let mut now = vec![VENTED; boards];
        let status = source.commands.fill((t_s * 1e9) as u64, &mut now);
        times.push(t_s);
        commands.push(now);
        if status == SourceStatus::Ended {
            break;
        }
    }
    (times, commands)
}

/// One for all channels that are commanded the same under the same limit.
fn plots(commands: &[Vec<BoardCommand>], boards: usize, setup: &Setup, limits: &Limits) -> Vec<Plot> {
    let mut plots: Vec<Plot> = Vec::new();
    for (index, board) in (0..boards).zip(0..=u8::MAX) {
        for channel in 0..CHANNELS {
            let scale = setup.calibration.channel(board, channel);
            let kpa: Vec<f64> = commands.iter().map(|now| scale.command_kpa(now[index][channel])).collect();
            let limit = limits.of(board)[channel];
            let same = |plot: &&mut Plot| {
                plot.kpa == kpa
                    && (plot.limit_kpa, plot.limit_rate_kpa_s) == (limit.max_kpa, limit.max_rate_kpa_s)
            };
            match plots.iter_mut().find(same) {
                Some(plot) => plot.places.push((board, channel)),
                None => plots.push(Plot {
                    places: vec![(board, channel)],
                    kpa,
                    limit_kpa: limit.max_kpa,
                    limit_rate_kpa_s: limit.max_rate_kpa_s,
                }),
            }
        }
    }
    plots
}

/// `board 0 (shoulder): channels 0 (front left), 1`, and so on.
fn names(places: &[(u8, usize)], setup: &Setup) -> String {
    let mut boards: Vec<(u8, Vec<String>)> = Vec::new();
    for &(board, channel) in places {
        let own = setup.channel(board, channel).map_or_else(String::new, |name| format!(" ({name})"));
        let text = format!("{channel}{own}");
        match boards.last_mut() {
            Some((last, channels)) if *last == board => channels.push(text),
            _ => boards.push((board, vec![text])),
        }
    }
    let texts = boards.iter().map(|(board, channels)| {
        let noun = if channels.len() == 1 { "channel" } else { "channels" };
        format!("{}: {noun} {}", setup.board(*board), channels.join(", "))
    });
    texts.collect::<Vec<_>>().join("; ")
}

fn range(kpa: &[f64]) -> (f64, f64) {
    kpa.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &kpa| (low.min(kpa), high.max(kpa)))
}

/// The lines of a picture of `points`, from 0 to `high`.
fn picture(points: &[(f64, f64)], seconds: f64, high: f64, ends: [String; 2], width: u16) -> Vec<String> {
    let area = Rect::new(0, 0, width, HEIGHT);
    let mut buffer = Buffer::empty(area);
    let data = Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line).data(points);
    let times = ["0 s".to_owned(), format!("{seconds:.1} s")];
    let axis =
        |labels: [String; 2], to: f64| Axis::default().bounds([0.0, to]).labels(labels.map(Line::from));
    Chart::new(vec![data]).x_axis(axis(times, seconds)).y_axis(axis(ends, high)).render(area, &mut buffer);
    let line = |y: u16| {
        let cells = (0..width).map(|x| buffer[(x, y)].symbol());
        cells.collect::<String>().trim_end().to_owned()
    };
    (0..HEIGHT).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_drawn_where_it_is() {
        let points: Vec<_> = (0..=100).map(|t| (f64::from(t), if t < 50 { 0.0 } else { 80.0 })).collect();
        let lines = picture(&points, 100.0, 80.0, ["0.0".into(), "80.0".into()], 60);
        assert!(lines[0].starts_with("80.0"), "{lines:#?}");
        let filled = |line: &str| line.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
        // The upper level takes the right half of the first line, the lower one the left half of
        // the last above the axis.
        let upper = filled(&lines[0]);
        let lower = lines.iter().rev().map(|line| filled(line)).find(|&dots| dots > 0).unwrap();
        assert!((20..40).contains(&upper) && (20..40).contains(&lower), "{lines:#?}");
        assert!(lines.last().unwrap().contains("100.0 s"), "{lines:#?}");
    }
}
