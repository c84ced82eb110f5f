//! Parameters of many chambers, from an array or from a dictionary of arrays.

use super::super::shapes::{Extent, Values, numbers};
use crate::arrays::shape_text;
use crate::errors;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Parameters of every chamber.
#[derive(Debug)]
pub struct ParameterTable {
    values: Vec<f64>,
    /// As they were given; of a dictionary, that of one array for all of them.
    shape: Vec<usize>,
    width: usize,
}

impl ParameterTable {
    /// An array of shape (parameters,) or (chambers, parameters), or a dictionary from all of
    /// `names` to arrays of shape () or (chambers,). Of a calibrated model they may be left out, or
    /// some of the dictionary.
    pub fn extract(
        given: Option<&Bound<'_, PyAny>>,
        names: &[String],
        calibrated: Option<&[f64]>,
    ) -> PyResult<Self> {
        let width = names.len();
        let Some(object) = given else {
            let values = calibrated.ok_or_else(|| {
                errors::unusable("parameters is None: only a model that was calibrated has values of its own")
            })?;
            return Ok(Self { values: values.to_vec(), shape: vec![width], width });
        };
        let (shape, values) = match object.cast::<PyDict>() {
            Ok(dict) => from_dict(dict, names, calibrated)?,
            Err(_) => {
                let (shape, values) = numbers("parameters", object)?;
                match shape[..] {
                    [last] | [_, last] if last == width => (shape, values.to_vec()),
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
        Ok(Self { values, shape, width })
    }

    pub fn shape(&self) -> &[usize] {
        &self.shape
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

fn from_dict(
    dict: &Bound<'_, PyDict>,
    names: &[String],
    calibrated: Option<&[f64]>,
) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let given: Vec<String> = dict.keys().extract().map_err(|error| {
        errors::instead_of(dict.py(), error, || errors::unusable("names of parameters are texts"))
    })?;
    if let Some(unknown) = given.iter().find(|name| !names.contains(name)) {
        return Err(errors::unusable(format!("no parameter {unknown}; there is {}", names.join(", "))));
    }
    let mut columns = Vec::with_capacity(names.len());
    let (mut chambers, mut shared) = (Extent::new("chambers"), true);
    for (k, name) in names.iter().enumerate() {
        let value = match (dict.get_item(name)?, calibrated) {
            (Some(value), _) => value,
            (None, Some(calibrated)) => {
                columns.push(Values::Own(vec![calibrated[k]]));
                continue;
            }
            (None, None) => return Err(errors::unusable(format!("parameter {name} is missing"))),
        };
        let (shape, values) = numbers(name, &value)?;
        if shape.len() > 1 {
            return Err(errors::unusable(format!(
                "parameter {name} has shape {}; expected () or (chambers,)",
                shape_text(&shape)
            )));
        }
        chambers.join("a parameter", values.len())?;
        shared &= shape.is_empty();
        columns.push(values);
    }
    let (number, width) = (chambers.number(), names.len());
    let shape = if shared { vec![width] } else { vec![number, width] };
    let at = |column: &[f64], chamber: usize| column[if column.len() == 1 { 0 } else { chamber }];
    let values = (0..number).flat_map(|chamber| columns.iter().map(move |c| at(c, chamber)));
    Ok((shape, values.collect()))
}
