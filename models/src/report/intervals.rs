//! Values with their intervals, one line each: drawn with boxes, so that text keeps its size on any
//! screen.

use maud::{Markup, html};

use super::significant;

/// One line: a value and the range it lies in.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// What it is the value of.
    pub label: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval; `None` where the data do not determine it.
    pub range: Option<[f64; 2]>,
    /// Does it stand out?
    pub bold: bool,
}

/// Some values of one quantity on a common axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Intervals {
    /// What the quantity is, with its unit.
    pub title: String,
    /// The lines, from above.
    pub lines: Vec<Interval>,
    /// A value that belongs in the picture, with its name: where the effect would be absent.
    pub mark: Option<(f64, String)>,
}

/// The part of the axis that is left free at each end, percent.
const MARGIN: f64 = 6.0;

impl Intervals {
    /// The figure; nothing where no line has an interval.
    #[must_use]
    pub fn markup(&self) -> Markup {
        let ends = self.lines.iter().flat_map(|l| l.range.into_iter().flatten().chain([l.value]));
        let all = ends.chain(self.mark.iter().map(|m| m.0)).filter(|v| v.is_finite());
        let (low, high) =
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if !(low < high) || self.lines.iter().all(|l| l.range.is_none()) {
            return html! {};
        }
        let at = |value: f64| MARGIN + (100.0 - 2.0 * MARGIN) * (value - low) / (high - low);
        let from = |value: f64| format!("left:{:.2}%", at(value));
        html! {
            figure.intervals {
                figcaption { strong { (self.title) } }
                @for line in &self.lines {
                    div.interval.bold[line.bold] {
                        span.what { (line.label) }
                        span.track {
                            @if let Some((mark, _)) = &self.mark { i.mark style=(from(*mark)) {} }
                            @if let Some([low, high]) = line.range {
                                i.range style={ (from(low)) ";width:" (format!("{:.2}%", at(high) - at(low))) } {}
                                i.point style=(from(line.value)) {}
                            } @else {
                                span.unknown { "not determined by this recording" }
                            }
                        }
                    }
                }
                div.interval {
                    span.what {}
                    span.track.axis {
                        span style=(from(low)) { (significant(low, 3)) }
                        span style=(from(high)) { (significant(high, 3)) }
                    }
                }
                @if let Some((mark, name)) = &self.mark {
                    p.caption { "Grey line: " (name) " (" (significant(*mark, 3)) ")." }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(value: f64, range: Option<[f64; 2]>) -> Interval {
        Interval { label: "b0c0".to_owned(), value, range, bold: false }
    }

    #[test]
    fn the_interval_is_where_its_values_say() {
        let lines = vec![line(5.0, Some([2.5, 7.5])), line(3.0, None)];
        let plot = Intervals { title: "width".to_owned(), lines, mark: Some((0.0, "absent".to_owned())) };
        let html = plot.markup().into_string();
        // From 0 to 7.5 over the middle 88 %: 2.5 is a third of the way.
        assert!(html.contains("left:35.33%;width:58.67%"), "{html}");
        assert!(html.contains("not determined by this recording") && html.contains("Grey line: absent (0)"));
    }

    #[test]
    fn without_any_interval_there_is_no_picture() {
        let plot = Intervals { title: "width".to_owned(), lines: vec![line(5.0, None)], mark: None };
        assert_eq!(plot.markup().into_string(), "");
    }
}
