//! What a model leaves open, as standard deviations.

/// Number of these.
pub const COUNT: usize = 3;

/// Standard deviations of what is not modelled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of the supply pressure, relative, in a wander over `greybox_supply_s`.
    pub supply: f64,
    /// Of the reading, Pa, in a deviation over `greybox_discrepancy_s`.
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
