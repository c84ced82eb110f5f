//! Which parameters are free, and the coordinates a fit moves in.

use thiserror::Error;

use crate::model::{Parameter, Scale};
use crate::numeric::{Dual, Real, Scalar};

/// Why parameters cannot be fitted as asked.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SpaceError {
    /// No parameter of that name.
    #[error("no parameter is called `{name}`; there are {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// A value or bound is not a number, out of order, or not positive on a logarithmic scale.
    #[error("parameter `{name}`: {lower} <= {value} <= {upper} does not hold or does not suit its scale")]
    Range {
        /// The parameter.
        name: String,
        /// Lower bound.
        lower: f64,
        /// Value.
        value: f64,
        /// Upper bound.
        upper: f64,
    },
}

/// The parameters of a fit: each free within its bounds, or fixed.
///
/// A fit moves in *coordinates*: the values of the free parameters in their order, logarithms where
/// the scale says so.
#[derive(Debug, Clone, PartialEq)]
pub struct Space {
    parameters: Vec<Parameter>,
    fixed: Vec<bool>,
}

impl Space {
    /// All parameters free, starting at their nominal values.
    #[must_use]
    pub fn new(parameters: Vec<Parameter>) -> Self {
        let fixed = parameters.iter().map(|parameter| parameter.lower >= parameter.upper).collect();
        Self { parameters, fixed }
    }

    /// Fixes a parameter at a value (which may lie outside its bounds).
    ///
    /// # Errors
    /// An unknown name, or a value that is not finite.
    pub fn fix(&mut self, name: &str, value: f64) -> Result<(), SpaceError> {
        let index = self.index(name)?;
        if !value.is_finite() {
            return Err(SpaceError::Range { name: name.to_owned(), lower: value, value, upper: value });
        }
        self.parameters[index].nominal = value;
        self.fixed[index] = true;
        Ok(())
    }

    /// Frees a parameter within bounds, with the first start at `nominal`.
    ///
    /// # Errors
    /// An unknown name, or bounds that are out of order or do not suit the parameter's scale.
    pub fn free(&mut self, name: &str, (lower, nominal, upper): (f64, f64, f64)) -> Result<(), SpaceError> {
        let index = self.index(name)?;
        let parameter = &mut self.parameters[index];
        let ordered =
            lower.is_finite() && upper.is_finite() && lower <= nominal && nominal <= upper && lower < upper;
        if !ordered || (parameter.scale == Scale::Logarithmic && lower <= 0.0) {
            return Err(SpaceError::Range { name: name.to_owned(), lower, value: nominal, upper });
        }
        (parameter.lower, parameter.nominal, parameter.upper) = (lower, nominal, upper);
        self.fixed[index] = false;
        Ok(())
    }

    /// Starts at these values; free ones are moved into their bounds. `values` in the order of the
    /// parameters.
    #[must_use]
    pub fn starting_at(mut self, values: &[f64]) -> Self {
        for ((parameter, fixed), value) in self.parameters.iter_mut().zip(&self.fixed).zip(values) {
            parameter.nominal = if *fixed { *value } else { value.clamp(parameter.lower, parameter.upper) };
        }
        self
    }

    fn index(&self, name: &str) -> Result<usize, SpaceError> {
        let found = self.parameters.iter().position(|parameter| parameter.name == name);
        found.ok_or_else(|| SpaceError::Unknown {
            name: name.to_owned(),
            known: self.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }

    /// All parameters, free and fixed.
    #[must_use]
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Indices of the free parameters.
    pub fn free_indices(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parameters.len()).filter(|&index| !self.fixed[index])
    }

    /// Number of free parameters.
    #[must_use]
    pub fn free_count(&self) -> usize {
        self.free_indices().count()
    }

    /// Coordinates of the nominal values.
    #[must_use]
    pub fn nominal(&self) -> Vec<f64> {
        self.free_indices().map(|i| coordinate(&self.parameters[i], self.parameters[i].nominal)).collect()
    }

    /// Bounds of the coordinates.
    #[must_use]
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        let bound = |i: usize| {
            let parameter = &self.parameters[i];
            (coordinate(parameter, parameter.lower), coordinate(parameter, parameter.upper))
        };
        self.free_indices().map(bound).collect()
    }

    /// Values of all parameters at the given coordinates (extra coordinates are ignored).
    #[must_use]
    pub fn values(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut values: Vec<f64> = self.parameters.iter().map(|parameter| parameter.nominal).collect();
        for (index, coordinate) in self.free_indices().zip(coordinates) {
            values[index] = self.parameters[index].scale.value(*coordinate);
        }
        values
    }

    /// Values of all parameters with their derivatives by `W` coordinates from `first`: free
    /// parameter `first + j` in direction `j`.
    #[must_use]
    pub fn duals<R: Real, const W: usize>(&self, coordinates: &[f64], first: usize) -> Vec<Dual<R, W>> {
        let mut values: Vec<Dual<R, W>> =
            self.parameters.iter().map(|parameter| Dual::constant(parameter.nominal)).collect();
        for (direction, (index, coordinate)) in self.free_indices().zip(coordinates).enumerate() {
            let variable = Dual::variable(R::constant(*coordinate), direction.wrapping_sub(first));
            values[index] = match self.parameters[index].scale {
                Scale::Linear => variable,
                Scale::Logarithmic => variable.exp(),
            };
        }
        values
    }

    /// Derivative of each free parameter's value by its coordinate.
    #[must_use]
    pub fn slopes(&self, coordinates: &[f64]) -> Vec<f64> {
        let slope = |(i, coordinate): (usize, &f64)| match self.parameters[i].scale {
            Scale::Linear => 1.0,
            Scale::Logarithmic => coordinate.exp(),
        };
        self.free_indices().zip(coordinates).map(slope).collect()
    }
}

fn coordinate(parameter: &Parameter, value: f64) -> f64 {
    parameter.scale.coordinate(value)
}
