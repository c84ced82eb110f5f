//! Constants of the air in the chambers.

/// Ratio of the specific heats of air.
pub const GAMMA: f64 = 1.4;

/// Standard atmosphere, Pa.
pub const ATMOSPHERE_PA: f64 = 101_325.0;

/// The gas around and in the chambers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    /// Specific gas constant, J/(kg K).
    pub constant_j_kg_k: f64,
    /// Temperature, K.
    pub temperature_k: f64,
    /// Ambient pressure, absolute, Pa.
    pub ambient_pa: f64,
}

impl Default for Gas {
    /// Dry air at 20 degrees Celsius and standard atmospheric pressure.
    fn default() -> Self {
        Self { constant_j_kg_k: 287.05, temperature_k: 293.15, ambient_pa: ATMOSPHERE_PA }
    }
}

impl Gas {
    /// Rate of pressure per effective area, flow pressure and inverse volume:
    /// `gamma R T sqrt(2 / (R T))`, m/s.
    ///
    /// With the flow pressure of [`FlowFunction::pressure`](super::FlowFunction::pressure),
    /// `dp/dt = filling_speed * area * flow_pressure / volume`.
    #[must_use]
    pub fn filling_speed(&self) -> f64 {
        let specific = self.constant_j_kg_k * self.temperature_k;
        GAMMA * specific * (2.0 / specific).sqrt()
    }
}

/// Largest value of the flow function, reached when the flow is choked:
/// `(2 / (gamma + 1))^(1 / (gamma - 1)) sqrt(gamma / (gamma + 1))`, 0.4842 for air.
#[must_use]
pub fn psi_max() -> f64 {
    (2.0 / (GAMMA + 1.0)).powf(1.0 / (GAMMA - 1.0)) * (GAMMA / (GAMMA + 1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_flow_function_of_air_is_the_papers() {
        // (1 / 1.2)^2.5 * sqrt(1.4 / 2.4) = 0.633938 * 0.763763
        assert!((psi_max() - 0.484_178).abs() < 1e-6, "{}", psi_max());
    }

    #[test]
    fn filling_speed_is_gamma_times_the_root_of_two_r_t() {
        // 1.4 * sqrt(2 * 287.05 * 293.15) = 1.4 * 410.238
        assert!(
            (Gas::default().filling_speed() - 574.333).abs() < 1e-2,
            "{}",
            Gas::default().filling_speed()
        );
    }
}
