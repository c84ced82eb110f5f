//! Pages: one self-contained HTML file each, readable offline on a desk and on a phone.
//!
//! A page is a title, a lead sentence and sections ([`Page`]); a section holds text, [`Table`]s and
//! [`Plot`]s. Plots are inline SVG, drawn once for wide and once for narrow screens, because text
//! in a scaled picture would become unreadable. Long series keep the smallest and largest value of
//! each pixel column ([`decimate`]), so that no spike is lost and the file stays small.

pub mod decimate;
mod format;
mod intervals;
mod page;
mod palette;
mod plot;
mod svg;
mod table;

pub use format::{behind, duration_text, number, significant};
pub use intervals::{Interval, Intervals};
pub use maud::{Markup, PreEscaped, html};
pub use page::{Page, folded, fragment, notes, paragraph, with_code};
pub use palette::Colour;
pub use plot::{Mark, Plot, PlotSeries, Shade};
pub use svg::PlotError;
pub use table::{Align, Table};
