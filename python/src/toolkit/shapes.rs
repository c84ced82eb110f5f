//! Arrays of the shapes that a batch is made of, broadcast as NumPy does.

use crate::arrays::{Floats, floats, shape_text};
use crate::errors;
use numpy::PyUntypedArrayMethods;
use pneudrive_model::rollout::BatchColumn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::{Deref, Range};

/// Numbers row by row, where NumPy has them if possible: to copy a large array takes a tenth of the time of its simulation.
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

/// A quantity of every chamber at every row; where it does not depend on one of them, it is kept once.
pub struct Field<'py> {
    name: &'static str,
    values: Values<'py>,
    chambers: usize,
    rows: usize,
    /// What the values must be within, as far as that has not been looked at.
    range: Option<[f64; 2]>,
    unit: &'static str,
}

/// A [`Field`] as other threads may see it.
#[derive(Clone, Copy)]
pub struct FieldView<'a> {
    values: &'a [f64],
    chambers: usize,
    rows: usize,
    range: Option<[f64; 2]>,
}

impl<'py> Field<'py> {
    /// One value for all.
    pub fn constant(name: &'static str, value: f64) -> Self {
        Self { name, values: Values::Own(vec![value]), chambers: 1, rows: 1, range: None, unit: "" }
    }

    /// An array of shape (), (rows,) or (chambers, rows), whose values are to be finite and within `range`.
    pub fn extract(
        name: &'static str,
        object: &Bound<'py, PyAny>,
        range: [f64; 2],
        unit: &'static str,
    ) -> PyResult<Self> {
        let (shape, values) = numbers(name, object)?;
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
        Ok(Self { name, values, chambers, rows, range: Some(range), unit })
    }

    /// Whether all values are within the range. What a column of the batch is made of is looked at there.
    pub fn check(&self) -> PyResult<()> {
        let Self { name, values, chambers, rows, range, unit } = self;
        let Some([low, high]) = range else { return Ok(()) };
        let Some(at) = values.iter().position(|value| !(value >= low && value <= high)) else {
            return Ok(());
        };
        Err(errors::unusable(format!(
            "{name} is {} at row {}{}; it must be {low} to {high} {unit}",
            values[at],
            at % rows,
            if *chambers > 1 { format!(" of chamber {}", at / rows) } else { String::new() },
        )))
    }

    /// As it is, if all values are within the range.
    pub fn checked(self) -> PyResult<Self> {
        self.check().map(|()| Self { range: None, ..self })
    }

    /// Something of each row and the one after it (of the last row: of itself twice).
    pub fn pairwise(&self, combine: impl Fn(f64, f64) -> f64) -> Self {
        let of_one = |values: &[f64]| -> Vec<f64> {
            let next = values.iter().skip(1).chain(values.last());
            values.iter().zip(next).map(|(here, there)| combine(*here, *there)).collect()
        };
        let values = self.values.chunks(self.rows).flat_map(of_one).collect();
        Self { values: Values::Own(values), range: None, ..*self }
    }

    /// The same for other threads.
    pub fn view(&self) -> FieldView<'_> {
        FieldView { values: &self.values, chambers: self.chambers, rows: self.rows, range: self.range }
    }
}

impl<'a> FieldView<'a> {
    /// It as an input of some of the chambers.
    pub fn column(&self, chambers: &Range<usize>) -> BatchColumn<'a> {
        let (from, to) = (chambers.start * self.rows, chambers.end * self.rows);
        let column = match (self.chambers, self.rows) {
            (1, 1) => BatchColumn::constant(self.values[0]),
            (1, _) => BatchColumn::per_row(self.values),
            (_, 1) => BatchColumn::per_job(&self.values[from..to]),
            _ => BatchColumn::per_job_and_row(&self.values[from..to]),
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

/// Parameters of every chamber.
#[derive(Debug)]
pub struct ParameterTable {
    values: Vec<f64>,
    width: usize,
}

impl ParameterTable {
    /// An array of shape (parameters,) or (chambers, parameters), or a dictionary from all of `names` to arrays of shape () or
    /// (chambers,).
    pub fn extract(object: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Self> {
        let width = names.len();
        let values = match object.cast::<PyDict>() {
            Ok(dict) => from_dict(dict, names)?,
            Err(_) => {
                let (shape, values) = numbers("parameters", object)?;
                match shape[..] {
                    [last] | [_, last] if last == width => values.to_vec(),
                    _ => {
                        return Err(errors::unusable(format!(
                            "parameters has shape {}; expected ({width},) or (chambers, {width}): {}",
                            shape_text(&shape),
                            names.join(", ")
                        )));
                    }
                }
            }
        };
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (name, value) = (&names[at % width], values[at]);
            return Err(errors::unusable(format!("parameter {name} of chamber {} is {value}", at / width)));
        }
        Ok(Self { values, width })
    }

    pub fn chambers(&self) -> usize {
        self.values.len() / self.width
    }

    /// The parameters of a chamber.
    pub fn of(&self, chamber: usize) -> &[f64] {
        let chamber = if self.chambers() == 1 { 0 } else { chamber };
        &self.values[chamber * self.width..][..self.width]
    }
}

fn from_dict(dict: &Bound<'_, PyDict>, names: &[String]) -> PyResult<Vec<f64>> {
    let given: Vec<String> = dict.keys().extract().map_err(|error| {
        errors::instead_of(dict.py(), error, || errors::unusable("names of parameters are texts"))
    })?;
    if let Some(unknown) = given.iter().find(|name| !names.contains(name)) {
        return Err(errors::unusable(format!("no parameter {unknown}; there is {}", names.join(", "))));
    }
    let mut columns = Vec::with_capacity(names.len());
    let mut chambers = Extent::new("chambers");
    for name in names {
        let value = dict.get_item(name)?;
        let value = value.ok_or_else(|| errors::unusable(format!("parameter {name} is missing")))?;
        let (shape, values) = numbers(name, &value)?;
        if shape.len() > 1 {
            return Err(errors::unusable(format!(
                "parameter {name} has shape {}; expected () or (chambers,)",
                shape_text(&shape)
            )));
        }
        chambers.join("a parameter", values.len())?;
        columns.push(values);
    }
    let at = |column: &[f64], chamber: usize| column[if column.len() == 1 { 0 } else { chamber }];
    Ok((0..chambers.number()).flat_map(|chamber| columns.iter().map(move |c| at(c, chamber))).collect())
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
