//! Trends: each calibrated parameter over months of recordings, with intervals, and where it has
//! changed.
//!
//! ```text
//! parameter files of dated recordings -> series (one a channel and parameter)
//!     -> changes (where the level differs) -> sentences, page
//! ```
//!
//! Nothing here knows of folders or reads a clock; times are seconds since 1970.

mod changes;
mod date;
mod page;
mod point;
mod series;
mod words;

pub use changes::{Change, Levels, levels};
pub use date::TimeScale;
pub use page::trends_page;
pub use point::Point;
pub use series::{Calibration, Trend, trends};
pub use words::{changes, conclusion};
