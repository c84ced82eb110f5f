//! Inputs and measurements in the form the rollouts take.

use std::ops::Range;

use thiserror::Error;

use crate::model::column;

/// Why inputs cannot be simulated.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SeriesError {
    /// The tables do not have the same number of rows.
    #[error("{inputs} rows of inputs, but {measured} of measurements and {weights} of weights")]
    Lengths {
        /// Rows of inputs.
        inputs: usize,
        /// Rows of measurements.
        measured: usize,
        /// Rows of weights.
        weights: usize,
    },
    /// Too few columns, or a table that is not a whole number of rows.
    #[error("{values} input values do not make rows of {width} columns (at least {least})", least = column::COUNT)]
    Width {
        /// Number of values.
        values: usize,
        /// Columns in a row.
        width: usize,
    },
    /// A segment is shorter than two rows, overlaps the one before or ends after the last row.
    #[error(
        "segment {segment} covers rows {from}..{to} of {rows}; it must follow the one before and have two rows at least"
    )]
    Segment {
        /// Index of the segment.
        segment: usize,
        /// Its first row.
        from: usize,
        /// The row after its last.
        to: usize,
        /// Rows there are.
        rows: usize,
    },
    /// An input is not a number.
    #[error("input column {column} of row {row} is {value}; end the segment before it")]
    Input {
        /// Row.
        row: usize,
        /// Column.
        column: usize,
        /// The value.
        value: f64,
    },
    /// An interval is not positive.
    #[error("the interval after row {row} is {value} s; time stamps must increase within a segment")]
    Interval {
        /// Row.
        row: usize,
        /// The value, s.
        value: f64,
    },
    /// A weight is negative or not a number, or positive where there is no measurement.
    #[error("row {row} has weight {weight} and measurement {measured}")]
    Weight {
        /// Row.
        row: usize,
        /// The weight.
        weight: f64,
        /// The measurement.
        measured: f64,
    },
    /// A segment has no usable measurement to start from.
    #[error("segment {segment} has no usable measurement")]
    NothingMeasured {
        /// Segment.
        segment: usize,
    },
}

/// One row of inputs and measurements per sample, cut into segments that are simulated one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    width: usize,
    rows: Vec<f64>,
    measured: Vec<f64>,
    weights: Vec<f64>,
    segments: Vec<Range<usize>>,
    starts: Vec<f64>,
    interval_s: f64,
}

impl Series {
    /// Checks and takes the tables.
    ///
    /// * `rows`: row by row, `width` columns each, laid out as in [`mod@column`];
    /// * `measured`: absolute pressures in Pa, anything where the weight is zero;
    /// * `weights`: dimensionless factors of the residuals, 1 for a sample that counts, 0 for a
    ///   masked one;
    /// * `segments`: ranges of rows without gaps in time, each simulated from a start of its own.
    ///   Rows outside are skipped.
    ///
    /// # Errors
    /// Names the first row or segment that cannot be simulated.
    pub fn new(
        width: usize,
        rows: Vec<f64>,
        measured: Vec<f64>,
        weights: Vec<f64>,
        segments: Vec<Range<usize>>,
    ) -> Result<Self, SeriesError> {
        if width < column::COUNT || !rows.len().is_multiple_of(width) {
            return Err(SeriesError::Width { values: rows.len(), width });
        }
        let count = rows.len() / width;
        if measured.len() != count || weights.len() != count {
            return Err(SeriesError::Lengths {
                inputs: count,
                measured: measured.len(),
                weights: weights.len(),
            });
        }
        let mut end = 0;
        for (segment, range) in segments.iter().enumerate() {
            let Range { start: from, end: to } = *range;
            if from < end || to > count || to < from + 2 {
                return Err(SeriesError::Segment { segment, from, to, rows: count });
            }
            end = to;
            check_inputs(&rows, width, range)?;
            check_weights(&measured, &weights, range)?;
        }
        let starts = first_measurements(&measured, &weights, &segments)?;
        let interval_s = median_interval(&rows, width, &segments);
        Ok(Self { width, rows, measured, weights, segments, starts, interval_s })
    }

    /// Number of rows, whether in a segment or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.measured.len()
    }

    /// Is there no row at all?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.measured.is_empty()
    }

    /// Columns in a row of inputs.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// The inputs of one row.
    #[must_use]
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[f64] {
        &self.rows[row * self.width..][..self.width]
    }

    /// The inputs of a range of rows, row by row.
    #[must_use]
    pub fn inputs(&self, rows: Range<usize>) -> &[f64] {
        &self.rows[rows.start * self.width..rows.end * self.width]
    }

    /// Measured absolute pressures, Pa.
    #[must_use]
    pub fn measured(&self) -> &[f64] {
        &self.measured
    }

    /// Weights of the residuals.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Segments, as ranges of rows.
    #[must_use]
    pub fn segments(&self) -> &[Range<usize>] {
        &self.segments
    }

    /// First usable measurement of each segment, absolute, Pa.
    #[must_use]
    pub fn starts(&self) -> &[f64] {
        &self.starts
    }

    /// Median length of an interval, s.
    #[must_use]
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Number of measurements that count.
    #[must_use]
    pub fn usable(&self) -> usize {
        let rows = self.segments.iter().flat_map(|range| &self.weights[range.clone()]);
        rows.filter(|&&weight| weight > 0.0).count()
    }
}

fn check_inputs(rows: &[f64], width: usize, range: &Range<usize>) -> Result<(), SeriesError> {
    for row in range.clone() {
        let values = &rows[row * width..][..width];
        if let Some(column) = values.iter().position(|value| !value.is_finite()) {
            return Err(SeriesError::Input { row, column, value: values[column] });
        }
        let interval = values[column::INTERVAL_S];
        if interval <= 0.0 {
            return Err(SeriesError::Interval { row, value: interval });
        }
    }
    Ok(())
}

fn check_weights(measured: &[f64], weights: &[f64], range: &Range<usize>) -> Result<(), SeriesError> {
    for row in range.clone() {
        let (weight, measured) = (weights[row], measured[row]);
        let usable = weight >= 0.0 && weight.is_finite() && (weight == 0.0 || measured.is_finite());
        if !usable {
            return Err(SeriesError::Weight { row, weight, measured });
        }
    }
    Ok(())
}

fn first_measurements(
    measured: &[f64],
    weights: &[f64],
    segments: &[Range<usize>],
) -> Result<Vec<f64>, SeriesError> {
    let first = |(segment, range): (usize, &Range<usize>)| {
        let row = range.clone().find(|&row| weights[row] > 0.0);
        Ok(measured[row.ok_or(SeriesError::NothingMeasured { segment })?])
    };
    segments.iter().enumerate().map(first).collect()
}

fn median_interval(rows: &[f64], width: usize, segments: &[Range<usize>]) -> f64 {
    let mut intervals: Vec<f64> =
        segments.iter().flat_map(Range::clone).map(|row| rows[row * width + column::INTERVAL_S]).collect();
    if intervals.is_empty() {
        return 0.0;
    }
    let middle = intervals.len() / 2;
    *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
}
