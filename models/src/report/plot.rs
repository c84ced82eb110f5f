//! What a plot shows, apart from how it is drawn.

use maud::{Markup, PreEscaped, html};

use super::svg::{self, PlotError, Size};
use super::{Colour, decimate};

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through points ordered in x; broken where a value is not finite.
    Line,
    /// A bold line.
    BoldLine,
    /// Separate dots.
    Dots,
    /// Few points, each of which is to be seen.
    Points,
}

impl Mark {
    /// Whether points are joined.
    fn is_line(self) -> bool {
        matches!(self, Self::Line | Self::BoldLine)
    }
}

/// One curve or cloud.
#[derive(Debug, Clone)]
pub struct PlotSeries {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// Line or dots.
    pub mark: Mark,
    /// Points (x, y) in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// A shaded range of x.
#[derive(Debug, Clone)]
pub struct Shade {
    /// Name in the legend.
    pub name: String,
    /// First x.
    pub from: f64,
    /// Last x.
    pub to: f64,
}

/// A plot with one pair of axes.
#[derive(Debug, Clone, Default)]
pub struct Plot {
    /// What is to be seen, in a few words.
    pub title: String,
    /// Horizontal axis with its unit.
    pub x_label: String,
    /// Vertical axis with its unit.
    pub y_label: String,
    /// Curves and clouds, the first one lowest.
    pub series: Vec<PlotSeries>,
    /// Shaded ranges behind them.
    pub shades: Vec<Shade>,
    /// Places on the x axis that a thin upright line marks.
    pub moments: Vec<f64>,
    /// What these places are, in the legend; `event` where it is empty.
    pub moments_name: &'static str,
    /// Lowest and highest y; from the data where it is `None`.
    pub y_range: Option<(f64, f64)>,
    /// Whether y = 0 must be in the picture.
    pub include_zero: bool,
}

impl Plot {
    /// An empty plot.
    #[must_use]
    pub fn new(title: impl Into<String>, x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self { title: title.into(), x_label: x_label.into(), y_label: y_label.into(), ..Self::default() }
    }

    /// Adds a line.
    #[must_use]
    pub fn line(mut self, name: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        self.series.push(PlotSeries { name: name.into(), colour, mark: Mark::Line, points });
        self
    }

    /// Adds a bold line.
    #[must_use]
    pub fn bold_line(mut self, name: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        self.series.push(PlotSeries { name: name.into(), colour, mark: Mark::BoldLine, points });
        self
    }

    /// Adds dots.
    #[must_use]
    pub fn dots(mut self, name: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        self.series.push(PlotSeries { name: name.into(), colour, mark: Mark::Dots, points });
        self
    }

    /// Adds few points, each of which is to be seen.
    #[must_use]
    pub fn points(mut self, name: impl Into<String>, colour: Colour, points: Vec<(f64, f64)>) -> Self {
        self.series.push(PlotSeries { name: name.into(), colour, mark: Mark::Points, points });
        self
    }

    /// Adds a shaded range of x.
    #[must_use]
    pub fn shade(mut self, name: impl Into<String>, from: f64, to: f64) -> Self {
        self.shades.push(Shade { name: name.into(), from, to });
        self
    }

    /// Marks places on the x axis, and names them all in the legend.
    #[must_use]
    pub fn moments(mut self, at: impl IntoIterator<Item = f64>) -> Self {
        self.moments.extend(at);
        self
    }

    /// The same with another name for them.
    #[must_use]
    pub fn moments_called(mut self, name: &'static str, at: impl IntoIterator<Item = f64>) -> Self {
        self.moments_name = name;
        self.moments(at)
    }

    /// Keeps y = 0 in the picture.
    #[must_use]
    pub fn with_zero(mut self) -> Self {
        self.include_zero = true;
        self
    }

    /// The figure: title, legend, and the picture for wide and for narrow screens.
    ///
    /// # Errors
    /// [`PlotError`] when drawing fails or there is nothing finite to draw.
    pub fn markup(&self) -> Result<Markup, PlotError> {
        let wide = svg::draw(self, Size { width: 1040, height: 300 })?;
        let narrow = svg::draw(self, Size { width: 370, height: 250 })?;
        Ok(html! {
            figure {
                figcaption {
                    strong { (self.title) }
                    span.legend {
                        @for series in self.distinct_series() {
                            span.key {
                                i.line[series.mark.is_line()].dot[!series.mark.is_line()]
                                    style={ "background:" (series.colour.css()) } {}
                                (series.name)
                            }
                        }
                        @for (k, shade) in self.shades.iter().enumerate() {
                            @if self.shades[..k].iter().all(|s| s.name != shade.name) {
                                span.key { i.shade {} (shade.name) }
                            }
                        }
                        @if !self.moments.is_empty() {
                            span.key { i.moment {} (if self.moments_name.is_empty() { "event" } else { self.moments_name }) }
                        }
                    }
                }
                div.wide role="img" aria-label=(self.title) { (PreEscaped(wide)) }
                div.narrow role="img" aria-label=(self.title) { (PreEscaped(narrow)) }
            }
        })
    }

    /// One of each name: several that look the same may share one.
    fn distinct_series(&self) -> impl Iterator<Item = &PlotSeries> {
        let first_of = |name: &str| self.series.iter().position(|series| series.name == name);
        self.series
            .iter()
            .enumerate()
            .filter(move |(k, series)| first_of(&series.name) == Some(*k))
            .map(|(_, series)| series)
    }

    /// Smallest and largest x, over series and shades.
    pub(super) fn x_range(&self) -> Option<(f64, f64)> {
        let xs = self.series.iter().flat_map(|s| s.points.iter().map(|p| p.0));
        let shades = self.shades.iter().flat_map(|s| [s.from, s.to]);
        range(xs.chain(shades))
    }

    /// The y axis: as given, or what the data needs with a little room.
    pub(super) fn y_range(&self) -> Option<(f64, f64)> {
        if self.y_range.is_some() {
            return self.y_range;
        }
        let zero = self.include_zero.then_some(0.0);
        let (low, high) = range(self.series.iter().flat_map(|s| s.points.iter().map(|p| p.1)).chain(zero))?;
        let room = if high > low { 0.05 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        Some((low - room, high + room))
    }
}

impl PlotSeries {
    /// The unbroken lines to draw in a picture of `columns` pixels.
    pub(super) fn pieces(&self, x_range: (f64, f64), columns: usize) -> Vec<Vec<(f64, f64)>> {
        decimate::min_max(self.points.iter().copied(), x_range, columns)
    }

    /// The dots to draw.
    pub(super) fn cloud(&self, x: (f64, f64), y: (f64, f64), size: Size) -> Vec<(f64, f64)> {
        /// Dots closer than this many pixels are one.
        const CELL: u32 = 9;
        let cells = ((size.width / CELL) as usize, (size.height / CELL) as usize);
        decimate::thin(self.points.iter().copied(), x, y, cells)
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    (low <= high).then_some((low, high))
}
