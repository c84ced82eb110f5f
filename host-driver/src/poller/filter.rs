use pneudrive_protocol::CHANNELS;

/// The original host's low-pass: new = weight sample + (1 - weight) old.
///
/// Unlike the original's it starts at the first sample, not at 0, and starts again when a board was
/// away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureFilter {
    weight: f64,
}

/// A weight that makes no low-pass.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "filter weight of the new sample is {0}; it must be above 0 and at most 1 (1 is no filter, the original had 0.6)"
)]
pub struct FilterError(pub f64);

impl PressureFilter {
    /// The original's weight of the new sample.
    pub const ORIGINAL: Self = Self { weight: 0.6 };

    /// A filter with this weight of the new sample, 0 (excluded) to 1.
    ///
    /// # Errors
    /// Any other weight.
    pub fn new(weight: f64) -> Result<Self, FilterError> {
        if weight > 0.0 && weight <= 1.0 { Ok(Self { weight }) } else { Err(FilterError(weight)) }
    }

    /// The filtered pressures after `sample`, kPa. `before` is `None` at the start.
    pub fn step(&self, before: Option<[f64; CHANNELS]>, sample: [f64; CHANNELS]) -> [f64; CHANNELS] {
        let Some(before) = before else { return sample };
        std::array::from_fn(|channel| before[channel] + self.weight * (sample[channel] - before[channel]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The original's first value was 60 % of the truth.
    #[test]
    fn the_first_sample_is_the_truth() {
        let filter = PressureFilter::ORIGINAL;
        let first = filter.step(None, [100.0; 4]);
        assert!(first.iter().all(|p| (p - 100.0).abs() < 1e-12));
        let second = filter.step(Some(first), [200.0; 4]);
        assert!(second.iter().all(|p| (p - 160.0).abs() < 1e-12), "0.6 x 200 + 0.4 x 100: {second:?}");
    }

    #[test]
    fn weights_outside_the_range_are_refused() {
        for weight in [0.0, -0.1, 1.1, f64::NAN] {
            assert!(PressureFilter::new(weight).is_err(), "{weight}");
        }
    }
}
