//! What a model leaves open, as standard deviations.

/// Time constant of the wander of the supply, s.
pub const SUPPLY_S: f64 = 20.0;
/// Time constant of what the reading lacks, s. Longer ones would forgive a simulation that goes astray for seconds, shorter ones are
/// hardly told from noise.
pub const DISCREPANCY_S: f64 = 0.3;

/// Number of these.
pub const COUNT: usize = 3;

/// Standard deviations of what is not modelled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of the supply pressure, relative, in a wander over [`SUPPLY_S`].
    pub supply: f64,
    /// Of the reading, Pa, in a deviation over [`DISCREPANCY_S`].
    pub discrepancy_pa: f64,
    /// Of each reading, Pa: its noise.
    pub noise_pa: f64,
}

impl Uncertainty {
    /// Their logarithms, in which they are estimated.
    #[must_use]
    pub fn logarithms(&self) -> [f64; COUNT] {
        [self.supply, self.discrepancy_pa, self.noise_pa].map(f64::ln)
    }

    /// From their logarithms.
    #[must_use]
    pub fn from_logarithms(logarithms: &[f64]) -> Self {
        let [supply, discrepancy_pa, noise_pa] = [0, 1, 2].map(|k| f64::exp(logarithms[k]));
        Self { supply, discrepancy_pa, noise_pa }
    }
}
