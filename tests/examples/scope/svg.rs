//! Traces as a picture.

use crate::capture::{State, Trace};
use std::fmt::Write;

const WIDTH: f64 = 960.0;
const LEFT: f64 = 190.0;
const RIGHT: f64 = 20.0;
const ROW: f64 = 46.0;
const SWING: f64 = 24.0;
const HEAD: f64 = 40.0;
const FOOT: f64 = 46.0;

/// A length of time to be read off, drawn above a row.
pub struct Mark {
    /// Number of the row.
    pub row: usize,
    /// Start, us.
    pub from: f64,
    /// End, us.
    pub to: f64,
    /// What it is.
    pub text: String,
}

/// One screen of a scope.
pub struct Panel {
    /// What is seen.
    pub title: String,
    /// Left edge, us.
    pub from: f64,
    /// Right edge, us.
    pub to: f64,
    /// The time that the axis calls 0, us.
    pub zero: f64,
    /// From top to bottom.
    pub traces: Vec<Trace>,
    /// What is to be measured.
    pub marks: Vec<Mark>,
}

/// A picture of screens one below the other.
pub fn picture(panels: &[Panel]) -> String {
    let height: f64 = panels.iter().map(Panel::height).sum();
    let mut svg = header(height);
    let mut top = 0.0;
    for panel in panels {
        panel.draw(&mut svg, top);
        top += panel.height();
    }
    svg.push_str("</svg>\n");
    svg
}

/// The frame of any picture: a white page, and what lines and words look like.
pub fn header(height: f64) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"13\">\n<style>\
         .driven {{ fill: none; stroke: #1b5e8c; stroke-width: 2; }} \
         .released {{ fill: none; stroke: #888; stroke-width: 2; stroke-dasharray: 4 3; }} \
         .grid {{ stroke: #ddd; }} .mark {{ stroke: #b03030; fill: none; }} \
         .red {{ fill: #b03030; }} .title {{ font-weight: bold; }}</style>\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n"
    )
}

/// Distance of grid lines: 1, 2 or 5 times a power of ten, at most ten of them.
pub fn grid_step(span: f64) -> f64 {
    let decade = 10_f64.powf((span / 10.0).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|n| n * decade);
    steps.into_iter().find(|step| span / step <= 10.0).unwrap_or(steps[3])
}

impl Panel {
    fn height(&self) -> f64 {
        HEAD + ROW * self.traces.len() as f64 + FOOT
    }

    fn x(&self, us: f64) -> f64 {
        let part = (us - self.from) / (self.to - self.from);
        LEFT + part.clamp(0.0, 1.0) * (WIDTH - LEFT - RIGHT)
    }

    fn draw(&self, svg: &mut String, top: f64) {
        let bottom = top + HEAD + ROW * self.traces.len() as f64;
        text(svg, LEFT, top + 24.0, "start", "title", &self.title);
        self.draw_grid(svg, top + HEAD - 4.0, bottom + 6.0);
        for (row, trace) in self.traces.iter().enumerate() {
            let low = top + HEAD + ROW * (row + 1) as f64;
            text(svg, LEFT - 10.0, low - SWING / 2.0 + 4.0, "end", "", &trace.name);
            self.draw_trace(svg, trace, low);
        }
        for mark in &self.marks {
            self.draw_mark(svg, mark, top + HEAD + ROW * (mark.row + 1) as f64 - SWING - 8.0);
        }
    }

    fn draw_grid(&self, svg: &mut String, top: f64, bottom: f64) {
        let step = grid_step(self.to - self.from);
        let first = ((self.from - self.zero) / step).ceil() as i64;
        let last = ((self.to - self.zero) / step).floor() as i64;
        for n in first..=last {
            let (at, x) = (n as f64 * step, self.x(n as f64 * step + self.zero));
            line(svg, "grid", (x, top), (x, bottom));
            let digits = usize::from(step < 1.0) + usize::from(step < 0.1);
            text(svg, x, bottom + 16.0, "middle", "", &format!("{at:.digits$}"));
        }
        text(svg, LEFT - 40.0, bottom + 16.0, "end", "", "us");
    }

    fn draw_trace(&self, svg: &mut String, trace: &Trace, low: f64) {
        let y = |state: State| if state.is_high() { low - SWING } else { low };
        let ends = trace.changes.iter().skip(1).map(|(at, _)| *at).chain([f64::INFINITY]);
        let mut before = None;
        for ((from, state), to) in trace.changes.iter().zip(ends) {
            if to <= self.from || *from >= self.to {
                before = Some(*state);
                continue;
            }
            let class = if matches!(state, State::Driven(_)) { "driven" } else { "released" };
            if let Some(before) = before.filter(|before| y(*before) != y(*state) && *from > self.from) {
                line(svg, class, (self.x(*from), y(before)), (self.x(*from), y(*state)));
            }
            line(svg, class, (self.x(*from), y(*state)), (self.x(to), y(*state)));
            before = Some(*state);
        }
    }

    fn draw_mark(&self, svg: &mut String, mark: &Mark, y: f64) {
        let (from, to) = (self.x(mark.from), self.x(mark.to));
        line(svg, "mark", (from, y), (to, y));
        for x in [from, to] {
            line(svg, "mark", (x, y - 5.0), (x, y + SWING + 8.0));
        }
        let (x, anchor) = match to > WIDTH * 0.7 {
            true => (from - 6.0, "end"),
            false => (to + 6.0, "start"),
        };
        text(svg, x, y + 4.0, anchor, "red", &mark.text);
    }
}

/// A line from one point to another.
pub fn line(svg: &mut String, class: &str, from: (f64, f64), to: (f64, f64)) {
    let ((x1, y1), (x2, y2)) = (from, to);
    // Writing to a string does not fail.
    let _ = writeln!(
        svg,
        "<line class=\"{class}\" x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>"
    );
}

/// A line of words.
pub fn text(svg: &mut String, x: f64, y: f64, anchor: &str, class: &str, words: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" class=\"{class}\">{words}</text>"
    );
}
