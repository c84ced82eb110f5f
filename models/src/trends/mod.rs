//! Trends: each calibrated parameter over months of recordings, with intervals, and where it has changed.
//!
//! ```text
//! parameter files of dated recordings -> series (one a channel and parameter) -> changes (where the level differs) -> page
//! ```
//!
//! Nothing here knows of folders or reads a clock; times are seconds since 1970.

mod changes;
mod date;
mod page;
mod point;
mod series;

pub use changes::{Change, FEWEST_RECORDINGS, Levels, levels};
pub use date::day;
pub use page::trends_page;
pub use point::Point;
pub use series::{Calibration, Trend, trends};
