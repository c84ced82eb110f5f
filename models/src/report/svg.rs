//! Drawing a plot as SVG, with the crate plotters.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::plot::{Mark, Plot};

/// A picture that could not be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// No finite point in any series.
    #[error("plot \"{title}\": there is nothing to draw: no series holds a finite value")]
    Nothing {
        /// The plot's title.
        title: String,
    },
    /// The drawing library failed.
    #[error("plot \"{title}\": {message}")]
    Drawing {
        /// The plot's title.
        title: String,
        /// What it said.
        message: String,
    },
}

/// Size of a picture in CSS pixels at its natural scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Size {
    pub width: u32,
    pub height: u32,
}

/// The backend rounds to whole units; drawing this many times larger and scaling down by the view
/// box keeps curves smooth.
const FINE: u32 = 4;
const FONT_PX: u32 = 15;

const AXIS: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(228, 228, 228);
const TEXT: RGBColor = RGBColor(40, 40, 40);
const SHADE: RGBColor = RGBColor(238, 242, 247);
const ZERO: RGBColor = RGBColor(120, 120, 120);
const MOMENT: RGBColor = RGBColor(200, 50, 30);

/// Draws `plot` and returns an `<svg>` element that fills the width it is given.
pub(super) fn draw(plot: &Plot, size: Size) -> Result<String, PlotError> {
    let nothing = || PlotError::Nothing { title: plot.title.clone() };
    let (x, y) = (plot.x_range().ok_or_else(nothing)?, plot.y_range().ok_or_else(nothing)?);
    let x = if x.0 < x.1 { x } else { (x.0 - 0.5, x.1 + 0.5) };
    let mut text = String::new();
    draw_into(plot, size, x, y, &mut text)
        .map_err(|message| PlotError::Drawing { title: plot.title.clone(), message })?;
    Ok(scalable(&text, size))
}

/// Errors of the drawing backend, as text: its types borrow the backend.
fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn draw_into(plot: &Plot, size: Size, x: (f64, f64), y: (f64, f64), text: &mut String) -> Result<(), String> {
    let fine = |pixels: u32| pixels * FINE;
    let stroke = |tenths: u32| tenths * FINE / 10;
    let narrow = size.width < 500;
    let root = SVGBackend::with_string(text, (fine(size.width), fine(size.height))).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .margin_top(fine(8))
        .margin_right(fine(if narrow { 8 } else { 16 }))
        .x_label_area_size(fine(44))
        .y_label_area_size(fine(if narrow { 58 } else { 70 }))
        .build_cartesian_2d(x.0..x.1, y.0..y.1)
        .map_err(words)?;
    for shade in &plot.shades {
        let band = Rectangle::new([(shade.from, y.0), (shade.to, y.1)], SHADE.filled());
        chart.draw_series(std::iter::once(band)).map_err(words)?;
    }
    let font = ("sans-serif", fine(FONT_PX)).into_font().color(&TEXT);
    let axis_decimals = (decimals(x.1 - x.0), decimals(y.1 - y.0));
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID.stroke_width(stroke(10)))
        .axis_style(AXIS.stroke_width(stroke(10)))
        .set_all_tick_mark_size(fine(4))
        .label_style(font.clone())
        .axis_desc_style(font.pos(Pos::new(HPos::Center, VPos::Center)))
        .x_desc(&plot.x_label)
        .y_desc(&plot.y_label)
        .x_labels(if narrow { 5 } else { 11 })
        .y_labels(6)
        .x_label_formatter(&|v| tick(*v, axis_decimals.0))
        .y_label_formatter(&|v| tick(*v, axis_decimals.1))
        .draw()
        .map_err(words)?;
    if y.0 < 0.0 && y.1 > 0.0 {
        let zero = PathElement::new([(x.0, 0.0), (x.1, 0.0)], ZERO.stroke_width(stroke(10)));
        chart.draw_series(std::iter::once(zero)).map_err(words)?;
    }
    let inside = plot.moments.iter().filter(|at| (x.0..=x.1).contains(*at));
    let upright = |at: &f64| PathElement::new([(*at, y.0), (*at, y.1)], MOMENT.stroke_width(stroke(10)));
    chart.draw_series(inside.map(upright)).map_err(words)?;
    for series in &plot.series {
        let (r, g, b) = series.colour.rgb();
        let colour = RGBColor(r, g, b);
        match series.mark {
            Mark::Line | Mark::BoldLine => {
                let width = if series.mark == Mark::BoldLine { stroke(24) } else { stroke(14) };
                for piece in series.pieces(x, size.width as usize) {
                    chart.draw_series(LineSeries::new(piece, colour.stroke_width(width))).map_err(words)?;
                }
            }
            Mark::Dots => {
                let dots = series.cloud(x, y, size);
                let dots =
                    dots.into_iter().map(|point| Circle::new(point, stroke(16), colour.mix(0.55).filled()));
                chart.draw_series(dots).map_err(words)?;
            }
            Mark::Points => {
                let finite = series.points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
                let points = finite.map(|point| Circle::new(*point, stroke(35), colour.filled()));
                chart.draw_series(points).map_err(words)?;
            }
        }
    }
    root.present().map_err(words)
}

/// Decimals that tell neighbouring ticks apart on an axis of this length.
fn decimals(length: f64) -> usize {
    let wanted = 1.0 - length.abs().max(f64::MIN_POSITIVE).log10().floor();
    // A small number of digits by construction.
    wanted.clamp(0.0, 9.0) as usize
}

fn tick(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Replaces the fixed size in the root element: the picture takes the width of its place.
fn scalable(svg: &str, size: Size) -> String {
    let Some((_, content)) = svg.find("<svg").and_then(|start| svg[start..].split_once('>')) else {
        return svg.to_owned();
    };
    let (width, height) = (size.width * FINE, size.height * FINE);
    // The space between elements is a fifth of the file.
    let content: String = content.lines().map(str::trim_start).collect();
    format!(r#"<svg viewBox="0 0 {width} {height}" xmlns="http://www.w3.org/2000/svg">{content}"#)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Colour;

    #[test]
    fn a_long_series_makes_a_small_picture_with_units() {
        let points: Vec<(f64, f64)> =
            (0..1_000_000).map(|k| (f64::from(k) * 1e-3, (f64::from(k) * 0.01).sin())).collect();
        let plot =
            Plot::new("Pressure", "time (s)", "pressure (kPa)").line("measured", Colour::Measured, points);
        let svg = draw(&plot, Size { width: 1000, height: 300 }).unwrap();
        assert!(svg.len() < 60_000, "{} bytes", svg.len());
        assert!(svg.contains("pressure (kPa)") && svg.contains("time (s)"));
        assert!(svg.starts_with(r#"<svg viewBox="0 0 4000 1200""#) && svg.trim_end().ends_with("</svg>"));
    }

    #[test]
    fn nothing_to_draw_is_said() {
        let plot = Plot::new("Empty", "x", "y").line("none", Colour::Blue, vec![(0.0, f64::NAN)]);
        let error = draw(&plot, Size { width: 100, height: 100 }).unwrap_err();
        assert_eq!(
            error.to_string(),
            "plot \"Empty\": there is nothing to draw: no series holds a finite value"
        );
    }

    #[test]
    fn zero_has_a_line_only_where_values_lie_on_both_sides() {
        let lines = |low: f64| {
            let plot = Plot::new("", "", "").line("", Colour::Blue, vec![(0.0, low), (1.0, 5.0)]);
            let svg = draw(&plot, Size { width: 400, height: 200 }).unwrap();
            svg.matches("#787878").count()
        };
        assert_eq!((lines(-5.0), lines(1.0)), (1, 0));
    }

    #[test]
    fn ticks_have_the_digits_their_axis_needs() {
        assert_eq!((decimals(250.0), decimals(20.0), decimals(3.0), decimals(0.02)), (0, 0, 1, 3));
        assert_eq!(tick(0.0, 2), "0");
        assert_eq!(tick(-0.0001, 2), "0");
        assert_eq!(tick(2.50, 2), "2.5");
        assert_eq!(tick(100.0, 0), "100");
    }
}
