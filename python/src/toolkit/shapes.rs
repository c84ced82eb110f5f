//! Arrays of the shapes that a batch is made of, broadcast as NumPy does.

use crate::arrays::{Floats, floats, shape_text};
use crate::errors;
use numpy::{PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pneudrive_model::rollout::{BatchColumn, BatchValues};
use pyo3::prelude::*;
use std::ops::{Deref, Range};

/// Numbers row by row, where NumPy has them if possible: to copy a large array takes a tenth of the
/// time of its simulation.
pub enum Values<'py> {
    /// A contiguous array of floats.
    Lent(Floats<'py>),
    Own(Vec<f64>),
}

impl Deref for Values<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            // Only contiguous arrays are lent.
            Self::Lent(array) => array.as_slice().unwrap_or_default(),
            Self::Own(values) => values,
        }
    }
}

/// Numbers in the precision that they came in.
enum Precise<'py> {
    Double(Values<'py>),
    /// A contiguous array of shape (chambers, rows).
    Single(PyReadonlyArrayDyn<'py, f32>),
}

impl Precise<'_> {
    fn view(&self) -> BatchValues<'_> {
        match self {
            Self::Double(values) => BatchValues::Double(values),
            // Only contiguous arrays are kept.
            Self::Single(array) => BatchValues::Single(array.as_slice().unwrap_or_default()),
        }
    }
}

/// A quantity of every chamber at every row; where it does not depend on one of them, it is kept
/// once.
pub struct Field<'py> {
    name: &'static str,
    values: Precise<'py>,
    /// As it was given.
    shape: Vec<usize>,
    chambers: usize,
    rows: usize,
    /// What the values must be within, as far as that has not been looked at.
    range: Option<[f64; 2]>,
    unit: &'static str,
}

/// A [`Field`] as other threads may see it.
#[derive(Clone, Copy)]
pub struct FieldView<'a> {
    values: BatchValues<'a>,
    chambers: usize,
    rows: usize,
    range: Option<[f64; 2]>,
}

impl<'py> Field<'py> {
    /// One value for all.
    pub fn constant(name: &'static str, value: f64) -> Self {
        let values = Precise::Double(Values::Own(vec![value]));
        Self { name, values, shape: vec![], chambers: 1, rows: 1, range: None, unit: "" }
    }

    /// An array of shape (), (rows,) or (chambers, rows), whose values are to be finite and within
    /// `range`.
    pub fn extract(
        name: &'static str,
        object: &Bound<'py, PyAny>,
        range: [f64; 2],
        unit: &'static str,
    ) -> PyResult<Self> {
        let (shape, values) = precise_numbers(name, object)?;
        let (chambers, rows) = match shape[..] {
            [] => (1, 1),
            [rows] => (1, rows),
            [chambers, rows] => (chambers, rows),
            _ => {
                return Err(errors::unusable(format!(
                    "{name} has shape {}; expected (), (rows,) or (chambers, rows)",
                    shape_text(&shape)
                )));
            }
        };
        Ok(Self { name, values, shape, chambers, rows, range: Some(range), unit })
    }

    /// Whether all values are within the range. What a column of the batch is made of is looked at
    /// there.
    pub fn check(&self) -> PyResult<()> {
        let Self { name, chambers, rows, range, unit, .. } = self;
        let Some([low, high]) = range else { return Ok(()) };
        let wrong = |value: f64| !(value >= *low && value <= *high);
        let found = match self.values.view() {
            BatchValues::Double(values) => values.iter().copied().enumerate().find(|(_, v)| wrong(*v)),
            BatchValues::Single(values) => {
                values.iter().map(|v| f64::from(*v)).enumerate().find(|(_, v)| wrong(*v))
            }
        };
        let Some((at, value)) = found else { return Ok(()) };
        Err(errors::unusable(format!(
            "{name} is {value} at row {}{}; it must be {low} to {high}{}{unit}",
            at % rows,
            if *chambers > 1 { format!(" of chamber {}", at / rows) } else { String::new() },
            if unit.is_empty() { "" } else { " " },
        )))
    }

    /// As it is, if all values are within the range.
    pub fn checked(self) -> PyResult<Self> {
        self.check().map(|()| Self { range: None, ..self })
    }

    /// Something of each row and the one after it (of the last row: of itself twice).
    pub fn pairwise(&self, combine: impl Fn(f64, f64) -> f64) -> Self {
        let of_one = |chamber: usize| {
            let view = self.view();
            let at = move |row: usize| view.of(chamber, row);
            (0..self.rows).map(move |row| (at(row), at((row + 1).min(self.rows - 1))))
        };
        let pairs = (0..self.chambers).flat_map(of_one);
        let values = pairs.map(|(here, there)| combine(here, there)).collect();
        Self { values: Precise::Double(Values::Own(values)), shape: self.shape.clone(), range: None, ..*self }
    }

    /// The shape that it was given in.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The same for other threads.
    pub fn view(&self) -> FieldView<'_> {
        let Self { chambers, rows, range, .. } = *self;
        FieldView { values: self.values.view(), chambers, rows, range }
    }
}

impl<'a> FieldView<'a> {
    /// The value of a chamber at a row.
    pub fn of(&self, chamber: usize, row: usize) -> f64 {
        let chamber = if self.chambers == 1 { 0 } else { chamber };
        let at = chamber * self.rows + if self.rows == 1 { 0 } else { row };
        match self.values {
            BatchValues::Double(values) => values[at],
            BatchValues::Single(values) => f64::from(values[at]),
        }
    }

    /// It as an input of some of the chambers.
    pub fn column(&self, chambers: &Range<usize>) -> BatchColumn<'a> {
        let (from, to) = (chambers.start * self.rows, chambers.end * self.rows);
        let column = match (self.values, self.chambers, self.rows) {
            (BatchValues::Double(values), 1, 1) => BatchColumn::constant(values[0]),
            (BatchValues::Double(values), 1, _) => BatchColumn::per_row(values),
            (BatchValues::Double(values), _, 1) => BatchColumn::per_job(&values[from..to]),
            (BatchValues::Double(values), _, _) => BatchColumn::per_job_and_row(&values[from..to]),
            (BatchValues::Single(values), _, _) => BatchColumn::per_job_and_row(&values[from..to]),
        };
        self.range.map_or(column, |range| column.within(range))
    }
}

/// The common number of things along one dimension: 1 gives way.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    what: &'static str,
    number: usize,
    set_by: &'static str,
}

impl Extent {
    pub fn new(what: &'static str) -> Self {
        Self { what, number: 1, set_by: "nothing" }
    }

    /// Takes another array's number of them into account.
    pub fn join(&mut self, name: &'static str, number: usize) -> PyResult<()> {
        match (self.number, number) {
            (_, 0) => Err(errors::unusable(format!("{name} is empty"))),
            (_, 1) => Ok(()),
            (1, _) => {
                (self.number, self.set_by) = (number, name);
                Ok(())
            }
            (here, there) if here == there => Ok(()),
            (here, there) => Err(errors::unusable(format!(
                "{name} has {there} {} and {} has {here}",
                self.what, self.set_by
            ))),
        }
    }

    pub fn number(&self) -> usize {
        self.number
    }
}

/// Numbers of chambers and rows that all fields agree on.
pub fn joint(chambers: &mut Extent, rows: &mut Extent, fields: &[&Field<'_>]) -> PyResult<()> {
    for field in fields {
        chambers.join(field.name, field.chambers)?;
        rows.join(field.name, field.rows)?;
    }
    Ok(())
}

/// As [`numbers`], but an array of float32 with a row and a chamber of its own for each value stays
/// what it is.
fn precise_numbers<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<(Vec<usize>, Precise<'py>)> {
    if let Ok(array) = object.extract::<PyReadonlyArrayDyn<'py, f32>>()
        && array.is_c_contiguous()
        && matches!(*array.shape(), [chambers, rows] if chambers > 1 && rows > 1)
    {
        return Ok((array.shape().to_vec(), Precise::Single(array)));
    }
    let (shape, values) = numbers(name, object)?;
    Ok((shape, Precise::Double(values)))
}

/// Shape and values, row by row, of whatever NumPy can make a float array of.
pub fn numbers<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<(Vec<usize>, Values<'py>)> {
    let wrong = |got: &str| errors::unusable(format!("{name}: expected an array of numbers, got {got}"));
    let array = floats(object, wrong)?;
    let shape = array.shape().to_vec();
    let values = if array.is_c_contiguous() {
        Values::Lent(array)
    } else {
        Values::Own(array.as_array().iter().copied().collect())
    };
    Ok((shape, values))
}
