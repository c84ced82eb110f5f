//! What a model says about each of its parameters.

/// On which scale a parameter is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// As it is.
    Linear,
    /// By its logarithm: positive, and unknown in its order of magnitude.
    Logarithmic,
}

impl Scale {
    /// Where a value lies on the scale.
    #[must_use]
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.ln(),
        }
    }

    /// The value that lies there.
    #[must_use]
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Logarithmic => coordinate.exp(),
        }
    }

    /// A value moved along the scale.
    #[must_use]
    pub fn moved(self, value: f64, by: f64) -> f64 {
        match self {
            Self::Linear => value + by,
            Self::Logarithmic => value * by.exp(),
        }
    }
}

/// One parameter of a model. Units are chosen so that values are of order one.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name in files and reports; unique within a model.
    pub name: String,
    /// Unit, `1` when it has none.
    pub unit: &'static str,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Where the first start of a fit lies.
    pub nominal: f64,
    /// Scale of fitting.
    pub scale: Scale,
    /// What it means, in a few words.
    pub meaning: &'static str,
}

impl Parameter {
    /// A parameter fitted as it is.
    #[must_use]
    pub fn linear(
        name: &str,
        unit: &'static str,
        (lower, nominal, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        Self { name: name.to_owned(), unit, lower, upper, nominal, scale: Scale::Linear, meaning }
    }

    /// A parameter fitted by its logarithm; the bounds must be positive.
    #[must_use]
    pub fn logarithmic(
        name: &str,
        unit: &'static str,
        (lower, nominal, upper): (f64, f64, f64),
        meaning: &'static str,
    ) -> Self {
        Self { name: name.to_owned(), unit, lower, upper, nominal, scale: Scale::Logarithmic, meaning }
    }

    /// The bounds on the scale of fitting.
    #[must_use]
    pub fn coordinate_bounds(&self) -> (f64, f64) {
        (self.scale.coordinate(self.lower), self.scale.coordinate(self.upper))
    }
}

/// The nominal values in the order of the parameters.
#[must_use]
pub fn nominal_values(parameters: &[Parameter]) -> Vec<f64> {
    parameters.iter().map(|parameter| parameter.nominal).collect()
}
