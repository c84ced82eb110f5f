//! Mass flow through an orifice after ISO 6358-1.
//!
//! With the upstream pressure `p_u`, the downstream pressure `p_d`, `r = p_d / p_u` and the critical ratio `b`,
//! `m = A C_d psi(r) p_u sqrt(2 / (R T))` and
//!
//! * choked, `r <= b`: `psi = psi_max`;
//! * subsonic: `psi = psi_max sqrt(1 - ((r - b) / (1 - b))^2)`;
//! * laminar, `r >= 0.999`: the straight line to zero at `r = 1`, because the subsonic slope is infinite there.
//!
//! The paper prints the subsonic branch without the inner square; [`FlowForm::Printed`] reproduces it.
//!
//! What is computed is the *flow pressure* `psi(r) p_u`, written without a division:
//! `p_u sqrt(1 - z^2) = sqrt(p_u^2 - (z p_u)^2)` with `z p_u = max(0, p_d - b p_u) / (1 - b)`.

use super::gas::psi_max;
use crate::numeric::{Real, Scalar};

/// The subsonic branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FlowForm {
    /// `sqrt(1 - z^2)`, the standard's.
    #[default]
    Iso6358,
    /// `sqrt(1 - z)`, as printed in the paper.
    Printed,
}

/// The flow function with its constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowFunction {
    critical_ratio: f64,
    /// `1 / (1 - b)`.
    subsonic_scale: f64,
    laminar_ratio: f64,
    /// Slope of the laminar segment, `psi(laminar_ratio) / (1 - laminar_ratio)`.
    laminar_slope: f64,
    psi_max: f64,
    form: FlowForm,
}

impl FlowFunction {
    /// Pressure ratio above which the flow is taken as laminar.
    pub const LAMINAR_RATIO: f64 = 0.999;

    /// The flow function of a valve with critical ratio `b`, `0 <= b < 0.999`.
    #[must_use]
    pub fn new(critical_ratio: f64, form: FlowForm) -> Self {
        let z = (Self::LAMINAR_RATIO - critical_ratio) / (1.0 - critical_ratio);
        let root = match form {
            FlowForm::Iso6358 => (1.0 - z * z).sqrt(),
            FlowForm::Printed => (1.0 - z).sqrt(),
        };
        Self {
            critical_ratio,
            subsonic_scale: 1.0 / (1.0 - critical_ratio),
            laminar_ratio: Self::LAMINAR_RATIO,
            laminar_slope: psi_max() * root / (1.0 - Self::LAMINAR_RATIO),
            psi_max: psi_max(),
            form,
        }
    }

    /// `psi` at a pressure ratio of 0 to 1.
    #[must_use]
    pub fn psi(&self, ratio: f64) -> f64 {
        self.pressure(1.0, ratio)
    }

    /// Flow pressure `psi p_u` in Pa between two absolute pressures in Pa, negative when the flow runs backwards.
    #[inline(always)]
    pub fn pressure<S: Scalar>(&self, from: S, to: S) -> S {
        let (value, by_from, by_to) = self.with_partials(from.real(), to.real());
        S::chain2(value, from, by_from, to, by_to)
    }

    /// The same from a known pressure.
    #[inline(always)]
    pub fn pressure_from<S: Scalar>(&self, from: S::Real, to: S) -> S {
        let (value, _, by_to) = self.with_partials(from, to.real());
        to.chain(value, by_to)
    }

    /// The same to a known pressure.
    #[inline(always)]
    pub fn pressure_to<S: Scalar>(&self, from: S, to: S::Real) -> S {
        let (value, by_from, _) = self.with_partials(from.real(), to);
        from.chain(value, by_from)
    }

    /// Flow pressure and its two partial derivatives. Unused derivatives are removed by the compiler.
    #[inline(always)]
    pub(crate) fn with_partials<R: Real>(&self, from: R, to: R) -> (R, R, R) {
        let backwards = from.below(to);
        let high = R::select(backwards, to, from);
        let low = R::select(backwards, from, to);

        let excess = (low - high.times(self.critical_ratio)).times(self.subsonic_scale);
        let choked = excess.below(R::zero());
        let w = R::select(choked, R::zero(), excess);
        // d(excess)/d(low) is the scale, d(excess)/d(high) is -b times it; both vanish when choked.
        let scale = R::select(choked, R::zero(), R::constant(self.subsonic_scale));
        let (root, by_high, by_low) = match self.form {
            FlowForm::Iso6358 => {
                let root = (high * high - w * w).sqrt();
                let inverse = R::constant(1.0) / root;
                let slope = w * scale;
                (root, (high + slope.times(self.critical_ratio)) * inverse, -(slope * inverse))
            }
            FlowForm::Printed => {
                let root = (high * (high - w)).sqrt();
                let inverse = R::constant(0.5) / root;
                let by_high = (high + high - w + high * scale.times(self.critical_ratio)) * inverse;
                (root, by_high, -(high * scale * inverse))
            }
        };
        let laminar = high.times(self.laminar_ratio).below(low);
        let slope = R::constant(self.laminar_slope);
        let value = R::select(laminar, (high - low) * slope, root.times(self.psi_max));
        let by_high = R::select(laminar, slope, by_high.times(self.psi_max));
        let by_low = R::select(laminar, -slope, by_low.times(self.psi_max));

        // Backwards, the flow changes sign, and `from` is the low side.
        (
            R::select(backwards, -value, value),
            R::select(backwards, -by_low, by_high),
            R::select(backwards, -by_high, by_low),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;

    /// Computed by hand with b = 0.3, psi_max = 0.484178:
    /// r = 0.65: z = 0.5; sqrt(0.75) = 0.866025, sqrt(0.5) = 0.707107.
    /// r = 0.9: z = 0.857143; sqrt(1 - 0.734694) = 0.515079, sqrt(0.142857) = 0.377964.
    #[test]
    fn both_forms_give_the_numbers_computed_by_hand() {
        let iso = FlowFunction::new(0.3, FlowForm::Iso6358);
        let printed = FlowFunction::new(0.3, FlowForm::Printed);
        for (ratio, expected_iso, expected_printed) in [
            (0.0, 0.484_178, 0.484_178),
            (0.3, 0.484_178, 0.484_178),
            (0.65, 0.419_311, 0.342_366),
            (0.9, 0.249_390, 0.183_002),
            (1.0, 0.0, 0.0),
        ] {
            assert!((iso.psi(ratio) - expected_iso).abs() < 2e-6, "iso at {ratio}: {}", iso.psi(ratio));
            assert!((printed.psi(ratio) - expected_printed).abs() < 2e-6, "printed at {ratio}");
        }
    }

    #[test]
    fn the_laminar_segment_joins_without_a_jump_and_has_a_finite_slope() {
        for form in [FlowForm::Iso6358, FlowForm::Printed] {
            let flow = FlowFunction::new(0.3, form);
            let (below, above) = (flow.psi(0.999 - 1e-12), flow.psi(0.999 + 1e-12));
            assert!((below - above).abs() < 1e-9, "{form:?}: {below} {above}");
            let slope = flow.psi(0.9995) / 0.0005;
            assert!((slope - flow.psi(0.9999) / 0.0001).abs() < 1e-6 * slope, "{form:?}: not a line");
        }
    }

    #[test]
    fn flow_runs_backwards_with_the_same_law() {
        let flow = FlowFunction::new(0.3, FlowForm::Iso6358);
        assert_eq!(flow.pressure(2.0e5, 5.0e5), -flow.pressure(5.0e5, 2.0e5));
    }

    #[test]
    fn partial_derivatives_agree_with_central_differences() {
        for form in [FlowForm::Iso6358, FlowForm::Printed] {
            let flow = FlowFunction::new(0.3, form);
            // choked, subsonic, laminar, and each of them backwards
            for (from, to) in [(6e5, 1e5), (6e5, 4e5), (6e5, 5.998e5), (1e5, 6e5), (4e5, 6e5), (5.998e5, 6e5)]
            {
                let exact = flow.pressure(Dual::<f64, 2>::variable(from, 0), Dual::variable(to, 1));
                let h = 1.0;
                let by_from = (flow.pressure(from + h, to) - flow.pressure(from - h, to)) / (2.0 * h);
                let by_to = (flow.pressure(from, to + h) - flow.pressure(from, to - h)) / (2.0 * h);
                assert!((exact.gradient[0] - by_from).abs() < 1e-6, "{form:?} {from} {to}");
                assert!((exact.gradient[1] - by_to).abs() < 1e-6, "{form:?} {from} {to}");
            }
        }
    }
}
