//! A parameter as one recording has it.

use serde::Serialize;

/// A parameter in one recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// When it was recorded, s since 1970.
    pub unix_s: f64,
    /// Its value.
    pub value: f64,
    /// 95 % interval, where there is one.
    pub ci95: Option<[f64; 2]>,
}
