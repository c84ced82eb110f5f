//! Flow through an orifice, ISO 6358-1:2013.
//!
//! `m = C rho_0 sqrt(T_0 / T_u) p_u phi(p_d / p_u)` with `phi = 1` up to the critical ratio `b` and
//! `phi = (1 - ((r - b) / (1 - b))^2)^m` above it. Reference state ANR: 293.15 K, 100 kPa, 65 %
//! humidity.

use super::background::{Deviation, factor};
use super::error::PlantError;

/// Density of air in the reference state ANR of ISO 8778, kg/m^3.
pub const ANR_DENSITY_KG_PER_M3: f64 = 1.185;
/// Temperature of the reference state ANR, K.
pub const ANR_TEMPERATURE_K: f64 = 293.15;

/// The flow function `phi` of ISO 6358 with a laminar segment next to equal pressures.
///
/// The subsonic branch has an infinite slope at `r = 1`, which no real orifice has and no fixed
/// step can follow: from `laminar_ratio` to 1 the straight line to zero is used, as usual in
/// simulation of ISO 6358 orifices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowFunction {
    critical_ratio: f64,
    exponent: f64,
    laminar_ratio: f64,
    per_subsonic: f64,
    laminar_slope: f64,
    /// Relative deviation over the pressure ratio.
    bend: Deviation,
}

impl Default for FlowFunction {
    /// `b = 0.30`, exponent 0.5, laminar from 0.999.
    fn default() -> Self {
        Self::unchecked(0.30, 0.5, 0.999)
    }
}

impl FlowFunction {
    /// A flow function with critical ratio `b` (0 to 0.8), subsonic exponent (0.2 to 1) and the
    /// pressure ratio from which the flow is laminar (above `b`, up to 0.99999).
    ///
    /// # Errors
    /// Names the argument that is outside its range.
    pub fn new(critical_ratio: f64, exponent: f64, laminar_ratio: f64) -> Result<Self, PlantError> {
        let refuse = |name, value, expected| Err(PlantError::Parameter { name, value, unit: "1", expected });
        if !(0.0..=0.8).contains(&critical_ratio) {
            return refuse("valve.flow.critical_ratio", critical_ratio, "0 to 0.8");
        }
        if !(0.2..=1.0).contains(&exponent) {
            return refuse("valve.flow.exponent", exponent, "0.2 to 1");
        }
        if !(laminar_ratio > critical_ratio && laminar_ratio <= 0.999_99) {
            return refuse(
                "valve.flow.laminar_ratio",
                laminar_ratio,
                "more than the critical ratio, up to 0.99999",
            );
        }
        Ok(Self::unchecked(critical_ratio, exponent, laminar_ratio))
    }

    fn unchecked(critical_ratio: f64, exponent: f64, laminar_ratio: f64) -> Self {
        let per_subsonic = 1.0 / (1.0 - critical_ratio);
        let x = (laminar_ratio - critical_ratio) * per_subsonic;
        let laminar_slope = (1.0 - x * x).powf(exponent) / (1.0 - laminar_ratio);
        Self { critical_ratio, exponent, laminar_ratio, per_subsonic, laminar_slope, bend: [0.0; 3] }
    }

    /// The same function with the critical ratio and the exponent moved. Whether the result is in
    /// range is checked with [`FlowFunction::new`] once everything is resolved.
    pub(super) fn changed_by(&self, critical_ratio: f64, exponent: f64) -> Self {
        let changed = Self::unchecked(
            self.critical_ratio + critical_ratio,
            self.exponent + exponent,
            self.laminar_ratio,
        );
        changed.bent_by(self.bend)
    }

    /// The same function times one plus a deviation over the pressure ratio.
    pub(super) fn bent_by(self, bend: Deviation) -> Self {
        Self { bend, ..self }
    }

    /// Critical pressure ratio `b`, 1.
    #[must_use]
    pub fn critical_ratio(&self) -> f64 {
        self.critical_ratio
    }

    /// Subsonic exponent `m`, 1.
    #[must_use]
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Pressure ratio from which the flow is laminar, 1.
    #[must_use]
    pub fn laminar_ratio(&self) -> f64 {
        self.laminar_ratio
    }

    /// Steepest slope of `phi`, reached in the laminar segment.
    pub(super) fn steepest(&self) -> f64 {
        self.laminar_slope * factor(&self.bend, 1.0)
    }

    /// `phi` at the ratio of the downstream to the upstream absolute pressure, 0 to 1.
    ///
    /// `phi` is concave, so the laminar chord lies below it between `laminar_ratio` and 1 and above
    /// it elsewhere: the smaller of the two is the function, without a branch.
    #[must_use]
    #[inline]
    pub fn phi(&self, ratio: f64) -> f64 {
        let x = ((ratio - self.critical_ratio) * self.per_subsonic).max(0.0);
        let inner = 1.0 - x * x;
        let subsonic = if self.exponent == 0.5 { inner.sqrt() } else { inner.max(0.0).powf(self.exponent) };
        subsonic.min(self.laminar_slope * (1.0 - ratio)) * factor(&self.bend, ratio)
    }

    /// Mass flow, kg/s, from `a` to `b` (negative when it goes back) through conductance
    /// `conductance` in m^3/(s Pa); absolute pressures in Pa, temperatures upstream of either
    /// direction in K.
    #[must_use]
    #[inline]
    pub fn mass_flow(&self, conductance: f64, a_pa: f64, a_k: f64, b_pa: f64, b_k: f64) -> f64 {
        if a_pa >= b_pa {
            conductance * gas_factor(a_k) * a_pa * self.phi(b_pa / a_pa)
        } else {
            -conductance * gas_factor(b_k) * b_pa * self.phi(a_pa / b_pa)
        }
    }
}

/// `rho_0 sqrt(T_0 / T)`.
#[inline]
fn gas_factor(temperature_k: f64) -> f64 {
    #[expect(clippy::float_cmp_const, reason = "the fixed-temperature plant passes the very constant")]
    if temperature_k == ANR_TEMPERATURE_K {
        ANR_DENSITY_KG_PER_M3
    } else {
        ANR_DENSITY_KG_PER_M3 * (ANR_TEMPERATURE_K / temperature_k).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Choked flow by the definition of the sonic conductance: 1 dm^3/(s bar) at 7 bar absolute
    /// passes 7 dm^3/s (ANR).
    #[test]
    fn choked_flow_is_the_sonic_conductance() {
        let flow = FlowFunction::default();
        let m = flow.mass_flow(1e-8, 7e5, ANR_TEMPERATURE_K, 1e5, ANR_TEMPERATURE_K);
        assert!((m - 7e-3 * 1.185).abs() < 1e-12, "{m}");
        // Hotter gas is thinner: sqrt(T_0 / T).
        let hot = flow.mass_flow(1e-8, 7e5, 4.0 * ANR_TEMPERATURE_K, 1e5, ANR_TEMPERATURE_K);
        assert!((hot - 0.5 * m).abs() < 1e-12);
    }

    /// Subsonic branch worked by hand: r = 0.65, b = 0.3 gives x = 0.5, phi = sqrt(0.75).
    #[test]
    fn subsonic_flow_is_the_ellipse() {
        let flow = FlowFunction::default();
        assert!((flow.phi(0.65) - 0.75_f64.sqrt()).abs() < 1e-15);
        assert!((flow.phi(0.3) - 1.0).abs() < 1e-15);
        assert!((flow.phi(0.1) - 1.0).abs() < 1e-15);
        assert!(flow.phi(1.0).abs() < 1e-15);
        let other = FlowFunction::new(0.5, 0.6, 0.999).unwrap();
        assert!((other.phi(0.75) - 0.75_f64.powf(0.6)).abs() < 1e-15);
    }

    #[test]
    fn laminar_segment_is_continuous_and_straight() {
        let flow = FlowFunction::default();
        let edge = flow.laminar_ratio();
        let x = (edge - 0.3) / 0.7;
        assert!((flow.phi(edge) - (1.0 - x * x).sqrt()).abs() < 1e-12);
        assert!((flow.phi(0.9995) - 0.5 * flow.phi(0.999)).abs() < 1e-12);
        // Just below the edge the ellipse holds, not the chord.
        let below = 0.99;
        let x = (below - 0.3) / 0.7;
        assert!((flow.phi(below) - (1.0 - x * x).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn flow_reverses_sign_and_upstream_side() {
        let flow = FlowFunction::default();
        let there = flow.mass_flow(1e-9, 3e5, 300.0, 2e5, 280.0);
        let back = flow.mass_flow(1e-9, 2e5, 280.0, 3e5, 300.0);
        assert!(there > 0.0);
        assert_eq!(there.to_bits(), (-back).to_bits());
    }

    #[test]
    fn refusals_name_the_argument() {
        let text = FlowFunction::new(0.9, 0.5, 0.999).unwrap_err().to_string();
        assert!(text.contains("critical_ratio") && text.contains("0.9"), "{text}");
        assert!(FlowFunction::new(0.3, 0.0, 0.999).unwrap_err().to_string().contains("exponent"));
        assert!(FlowFunction::new(0.3, 0.5, 0.2).unwrap_err().to_string().contains("laminar_ratio"));
        assert!(FlowFunction::new(f64::NAN, 0.5, 0.999).is_err());
    }
}
