//! Mass flow through an orifice after ISO 6358-1.
//!
//! With the upstream pressure `p_u`, the downstream pressure `p_d`, `r = p_d / p_u` and the
//! critical ratio `b`, `m = A C_d psi(r) p_u sqrt(2 / (R T))` and
//!
//! * choked, `r <= b`: `psi = psi_max`;
//! * subsonic: `psi = psi_max sqrt(1 - ((r - b) / (1 - b))^2)`;
//! * laminar, `r >= 0.999`: the straight line to zero at `r = 1`, because the subsonic slope is
//!   infinite there.
//!
//! The paper prints the subsonic branch without the inner square; [`FlowForm::Printed`] reproduces
//! it.
//!
//! What is computed is the *flow pressure* `psi(r) p_u`, without a division. With the drop
//! `d = p_u - p_d`, the drop that chokes `c = (1 - b) p_u` and what of the drop has an effect,
//! `e = min(d, c)`, both branches above are geometric means:
//!
//! * `p_u sqrt(1 - z^2) = sqrt(e (2 c - e)) / (1 - b)`, where `z = (r - b) / (1 - b)`, or 0 when
//!   choked;
//! * `p_u sqrt(1 - z) = sqrt(e c) / (1 - b)`, the paper's.
//!
//! Both are concave in the drop, so that the chord to its first thousandth is below them there and
//! above them beyond: the laminar segment is joined by taking the smaller of the two.

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
    /// Drop that chokes, by the upstream pressure: `1 - b`.
    choking_drop: f64,
    /// Mean of drops by the drop on the laminar segment.
    laminar_slope: f64,
    /// Flow pressure by the mean of drops: `psi_max / (1 - b)`.
    gain: f64,
    form: FlowForm,
}

impl FlowFunction {
    /// Pressure ratio above which the flow is taken as laminar.
    pub const LAMINAR_RATIO: f64 = 0.999;

    /// The flow function of a valve with critical ratio `b`, `0 <= b < 0.999`.
    #[must_use]
    pub fn new(critical_ratio: f64, form: FlowForm) -> Self {
        let choking_drop = 1.0 - critical_ratio;
        let drop = 1.0 - Self::LAMINAR_RATIO;
        let mean = match form {
            FlowForm::Iso6358 => (drop * (2.0 * choking_drop - drop)).sqrt(),
            FlowForm::Printed => (drop * choking_drop).sqrt(),
        };
        Self { choking_drop, laminar_slope: mean / drop, gain: psi_max() / choking_drop, form }
    }

    /// `psi` at a pressure ratio of 0 to 1.
    #[must_use]
    pub fn psi(&self, ratio: f64) -> f64 {
        self.pressure(1.0, ratio)
    }

    /// Flow pressure by the mean of drops that [`mean_from`](Self::mean_from) and
    /// [`mean_to`](Self::mean_to) give: a factor for the flow's conductance, which changes more
    /// rarely.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.gain
    }

    /// Flow pressure `psi p_u` in Pa between two absolute pressures in Pa, negative when the flow
    /// runs backwards.
    #[inline(always)]
    pub fn pressure<S: Scalar>(&self, from: S, to: S) -> S {
        let (value, by_from, by_to) = self.with_partials(from.real(), to.real());
        S::chain2(value, from, by_from, to, by_to)
    }

    /// Flow pressure by the [`gain`](Self::gain), in Pa, from a known pressure.
    #[inline(always)]
    pub fn mean_from<S: Scalar>(&self, from: S::Real, to: S) -> S {
        let (value, _, by_to) = self.mean_with_partials(from, to.real());
        to.chain(value, by_to)
    }

    /// Flow pressure by the [`gain`](Self::gain), in Pa, to a known pressure.
    #[inline(always)]
    pub fn mean_to<S: Scalar>(&self, from: S, to: S::Real) -> S {
        let (value, by_from, _) = self.mean_with_partials(from.real(), to);
        from.chain(value, by_from)
    }

    /// Of a passage with a laminar loss beside the orifice's: what flows, over the drop,
    /// `m / (p_u - p_d)`, with `F^2 = m^2 + 2 half m`. It is the same in both directions, and
    /// finite without a drop. `half` is in Pa and positive.
    #[inline(always)]
    pub(crate) fn conductance<S: Scalar>(&self, from: S, to: S, half: S) -> S {
        let (high, low) = (from.real().max(to.real()), from.real().min(to.real()));
        let drop = high - low;
        let choking = high.times(self.choking_drop);
        let one = S::Real::constant(1.0);
        let share = S::Real::select(choking.below(drop), choking / drop.plus(1e-9), one);
        let effective = drop * share;
        let squared_by_drop = share * (choking + choking - effective).times(self.gain * self.gain);
        let root = (squared_by_drop * drop + half.real().square()).sqrt();
        let value = squared_by_drop / (root + half.real());

        // By the drop and by the higher pressure, which chokes.
        let by_root = one / root;
        let by_square = share.times(self.gain * self.gain);
        let by_drop = -(by_square * share + value.square()) * by_root.times(0.5);
        let by_high = by_drop + (by_square * by_root).times(self.choking_drop);
        let backwards = from.real().below(to.real());
        let by_from = S::Real::select(backwards, -by_drop, by_high);
        let by_to = S::Real::select(backwards, by_high, -by_drop);
        S::chain_all(value, [from, to, half], [by_from, by_to, -(value * by_root)])
    }

    /// Flow pressure and its two partial derivatives. Unused derivatives are removed by the
    /// compiler.
    #[inline(always)]
    pub(crate) fn with_partials<S: Scalar>(&self, from: S, to: S) -> (S, S, S) {
        let (mean, by_from, by_to) = self.mean_with_partials(from, to);
        (mean.times(self.gain), by_from.times(self.gain), by_to.times(self.gain))
    }

    /// Over numbers with derivatives, those of the partial derivatives are the second ones.
    #[inline(always)]
    fn mean_with_partials<S: Scalar>(&self, from: S, to: S) -> (S, S, S) {
        let drop = from - to;
        let choking = from.max(to).times(self.choking_drop);
        let effective = drop.abs().min(choking);
        let mean = match self.form {
            FlowForm::Iso6358 => effective * (choking + choking - effective),
            FlowForm::Printed => effective * choking,
        };
        let mean = mean.sqrt();
        let line = drop.abs().times(self.laminar_slope);
        // Without a drop both are zero; there only the line has a slope.
        let turbulent = mean.less(line);
        // The drop falls with `to`; the higher pressure is `from`, or backwards, when the flow is
        // negative, `to`.
        let backwards = from.less(to);
        let value = mean.min(line);
        let value = S::select(backwards, -value, value);

        // The mean times its derivatives by the drop, zero when choked, and by the drop that
        // chokes.
        let (by_drop, by_choking) = match self.form {
            FlowForm::Iso6358 => (choking - effective, effective),
            FlowForm::Printed => {
                let choked = choking.less(drop.abs());
                let half = effective.times(0.5);
                (S::select(choked, S::zero(), choking.times(0.5)), S::select(choked, effective, half))
            }
        };
        let inverse = S::constant(1.0) / mean;
        let by_drop = S::select(turbulent, by_drop * inverse, S::constant(self.laminar_slope));
        let by_high = S::select(turbulent, by_choking.times(self.choking_drop) * inverse, S::zero());
        (
            value,
            by_drop + S::select(backwards, S::zero(), by_high),
            -(by_drop + S::select(backwards, by_high, S::zero())),
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

    /// The branches as the module's description gives them, with their divisions and case
    /// distinctions.
    #[test]
    fn the_means_of_drops_are_the_branches_of_the_standard() {
        for (form, b) in [(FlowForm::Iso6358, 0.3), (FlowForm::Printed, 0.3), (FlowForm::Iso6358, 0.99)] {
            let flow = FlowFunction::new(b, form);
            let branch = |r: f64| {
                let z = ((r - b) / (1.0 - b)).max(0.0);
                psi_max() * if form == FlowForm::Iso6358 { 1.0 - z * z } else { 1.0 - z }.sqrt()
            };
            for step in 0..=10_000 {
                let r = f64::from(step) / 1e4;
                let expected = if r < 0.999 { branch(r) } else { branch(0.999) * (1.0 - r) / 0.001 };
                assert!((flow.psi(r) - expected).abs() < 1e-13, "{form:?}, b {b}, at {r}: {}", flow.psi(r));
            }
        }
    }

    #[test]
    fn without_a_drop_nothing_flows_and_the_slope_is_the_laminar_segments() {
        let flow = FlowFunction::new(0.3, FlowForm::Iso6358);
        let (value, by_from, by_to) = flow.with_partials(4e5, 4e5);
        assert_eq!((value, by_to), (0.0, -by_from));
        assert!((by_from - flow.psi(0.999) / 0.001).abs() < 1e-9, "{by_from}");
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

    /// Of a passage whose loss is partly laminar, by both pressures and by that part: choked,
    /// subsonic, almost without a drop, and each of them backwards.
    #[test]
    fn slopes_of_a_conductance_agree_with_central_differences() {
        let flow = FlowFunction::new(0.3, FlowForm::Iso6358);
        for (from, to) in [(6e5, 1e5), (6e5, 4e5), (6e5, 5.99e5), (1e5, 6e5), (4e5, 6e5), (5.99e5, 6e5)] {
            let at = [from, to, 3e3];
            let [a, b, c] = [0, 1, 2].map(|k| Dual::<f64, 3>::variable(at[k], k));
            let exact = flow.conductance(a, b, c);
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut at = at;
                    at[k] += by;
                    flow.conductance(at[0], at[1], at[2])
                };
                let central = (moved(1.0) - moved(-1.0)) / 2.0;
                assert!(
                    (exact.gradient[k] - central).abs() < 1e-6 * central.abs().max(1e-6),
                    "{from} to {to}, by number {k}: {} and not {central}",
                    exact.gradient[k]
                );
            }
        }
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
