//! Two volumes with a tube between them: the port's, where the sensor sits, and the chamber's.
//!
//! The tube's flow over its drop is a conductance that changes slowly, though the drop may vanish:
//! with the conductance held, the two pressures are a linear system, whose step is exact for any
//! length and any stiffness (exponential midpoint rule, Hochbruck and Ostermann, Acta Numerica
//! 2010). What the conductance is in the middle of the step is told by half a step of the linearly
//! implicit Euler method, which needs no exponential.
//!
//! Derivatives of both steps are written out: what a pressure depends on is few numbers, and
//! carrying every derivative through some hundred operations would take several times as long.

use super::hook::LineParameters;
use super::phi::phi1_with_slope;
use crate::model::FlowFunction;
use crate::numeric::{Real, Scalar};

/// Half of the flow pressure below which the loss in any tube is laminar, Pa: its conductance is
/// finite without a drop.
const LEAST_LAMINAR_PA: f64 = 500.0;

/// What holds at the two ends during a step. Rates are those of the chamber's pressure.
#[derive(Debug, Clone, Copy)]
pub struct Ends<S> {
    /// What the valve adds to the port, Pa/s.
    pub driven: S,
    /// Its slope by the port's pressure, 1/s.
    pub slope: S,
    /// What the chamber's growth takes from its pressure, 1/s.
    pub swelling: S,
    /// Volume of the chamber over the port's.
    pub port: S,
    /// Nominal volume of the chamber over what it has.
    pub chamber: S,
}

/// The tube.
#[derive(Clone, Copy)]
pub struct Tube<'a, S> {
    /// The flow function of an orifice.
    pub flow: &'a FlowFunction,
    /// What the tube is.
    pub line: &'a LineParameters<S>,
}

impl<S: Scalar> Tube<'_, S> {
    /// About the pressures `[port, chamber]` in the middle of a step of `h` seconds.
    #[inline(always)]
    pub fn halfway(&self, h: f64, ends: &Ends<S>, pressures: [S; 2]) -> [S; 2] {
        Linear { ends, pressures, through: self.conductance(pressures) }.implicit(0.5 * h)
    }

    /// The pressures after `h` seconds, from those at their start and in the middle.
    #[inline(always)]
    pub fn advance(&self, h: f64, ends: &Ends<S>, pressures: [S; 2], halfway: [S; 2]) -> [S; 2] {
        Linear { ends, pressures, through: self.conductance(halfway) }.exponential(h)
    }

    /// The flow into the chamber, as a rate of its pressure, Pa/s.
    #[inline(always)]
    pub fn flow(&self, pressures: [S; 2]) -> S {
        self.conductance(pressures) * (pressures[0] - pressures[1])
    }

    /// Flow over drop, 1/s.
    #[inline(always)]
    fn conductance(&self, [port, chamber]: [S; 2]) -> S {
        let half = self.line.laminar_pa.times(0.5).plus(LEAST_LAMINAR_PA);
        self.flow.conductance(port, chamber, half) / self.line.time_constant_s
    }
}

/// The two pressures with the tube's conductance held.
#[derive(Clone, Copy)]
struct Linear<'a, S> {
    ends: &'a Ends<S>,
    /// Of port and chamber, absolute, Pa.
    pressures: [S; 2],
    /// Flow over drop, 1/s.
    through: S,
}

/// How the two pressures move.
struct Rates<R> {
    /// Rates, Pa/s.
    rates: [R; 2],
    /// Their slopes by the two pressures, row by row, 1/s.
    slopes: [R; 4],
}

impl<S: Scalar> Linear<'_, S> {
    #[inline(always)]
    fn rates(&self) -> Rates<S::Real> {
        let [driven, slope, swelling, to_port, to_chamber, through, port, chamber] =
            self.numbers().map(S::real);
        let flow = through * (port - chamber);
        let onward = through * to_chamber;
        Rates {
            rates: [(driven - flow) * to_port, flow * to_chamber - swelling * chamber],
            slopes: [(slope - through) * to_port, through * to_port, onward, -onward - swelling],
        }
    }

    /// What everything depends on.
    #[inline(always)]
    fn numbers(&self) -> [S; 8] {
        let &Ends { driven, slope, swelling, port, chamber } = self.ends;
        [driven, slope, swelling, port, chamber, self.through, self.pressures[0], self.pressures[1]]
    }

    /// The linearly implicit Euler step: `(1 - h A) z = h r` gives the change `z`, and its
    /// derivatives are the same step of `dr + dA z`.
    #[inline(always)]
    fn implicit(&self, h: f64) -> [S; 2] {
        let Rates { rates: [x, y], slopes: [a, b, c, d] } = self.rates();
        let (left, right) = ((-a.times(h)).plus(1.0), (-d.times(h)).plus(1.0));
        let factor = (left * right - (b * c).times(h * h)).recip().times(h);
        // Cramer's rule.
        let of_port = [right * factor, (b * factor).times(h)];
        let of_chamber = [(c * factor).times(h), left * factor];
        let change = [of_port[0] * x + of_port[1] * y, of_chamber[0] * x + of_chamber[1] * y];
        [
            self.changed(0, change[0], of_port, outer(of_port, change)),
            self.changed(1, change[1], of_chamber, outer(of_chamber, change)),
        ]
    }

    /// The exact step: `phi1` of the matrix of slopes is the line through its values at the
    /// eigenvalues, which are real since `b c > 0`.
    #[inline(always)]
    fn exponential(&self, h: f64) -> [S; 2] {
        let Rates { rates: [x, y], slopes: [a, b, c, d] } = self.rates();
        let (centre, half) = ((a + d).times(0.5), (a - d).times(0.5));
        let apart = (half.square() + b * c).plus(1e-6).sqrt();
        let by_apart = apart.recip();
        let (fast, fast_by) = phi1_with_slope((centre - apart).times(h));
        let (slow, slow_by) = phi1_with_slope((centre + apart).times(h));
        let (mean, tilt) = ((fast + slow).times(0.5 * h), (slow - fast) * by_apart.times(0.5 * h));
        let of_port = [mean + tilt * half, tilt * b];
        let of_chamber = [tilt * c, mean - tilt * half];

        let apart = Apart { h, half, b, c, by_apart, tilt, fast_by, slow_by };
        let [of_a, of_b, of_c, of_d] = apart.by_slopes(x, half * x + b * y, tilt * x);
        let change = of_port[0] * x + of_port[1] * y;
        let port = self.changed(0, change, of_port, [of_a, of_b + tilt * y, of_c, of_d]);
        let [of_a, of_b, of_c, of_d] = apart.by_slopes(y, c * x - half * y, -(tilt * y));
        let change = of_chamber[0] * x + of_chamber[1] * y;
        [port, self.changed(1, change, of_chamber, [of_a, of_b, of_c + tilt * x, of_d])]
    }

    /// One of the pressures after a change that follows the rates and their slopes with these
    /// partial derivatives.
    #[inline(always)]
    fn changed(&self, which: usize, change: S::Real, by_rates: [S::Real; 2], by_slopes: [S::Real; 4]) -> S {
        let numbers = self.numbers();
        let [driven, slope, swelling, to_port, to_chamber, through, port, chamber] = numbers.map(S::real);
        let [of_x, of_y] = by_rates;
        let [of_a, of_b, of_c, of_d] = by_slopes;
        let flow = through * (port - chamber);
        let (at_port, at_chamber) = (of_b - of_a, of_c - of_d);
        let net = of_y * to_chamber - of_x * to_port;
        // In the order of the numbers; the pressures are the last two.
        let mut partials = [
            of_x * to_port,
            of_a * to_port,
            -(of_y * chamber) - of_d,
            of_x * (driven - flow) + of_a * slope + at_port * through,
            of_y * flow + at_chamber * through,
            net * (port - chamber) + at_port * to_port + at_chamber * to_chamber,
            net * through,
            -(net * through) - of_y * swelling,
        ];
        partials[6 + which] = partials[6 + which].plus(1.0);
        let value = self.pressures[which].real() + change;
        S::chain_all(value, numbers, partials)
    }
}

/// Products of two numbers with two.
#[inline(always)]
fn outer<R: Real>([a, b]: [R; 2], [x, y]: [R; 2]) -> [R; 4] {
    [a * x, a * y, b * x, b * y]
}

/// What the exact step's derivatives by the slopes `[a, b, c, d]` are made of.
struct Apart<R> {
    /// Length of the step, s.
    h: f64,
    /// Half the difference of `a` and `d`, 1/s.
    half: R,
    b: R,
    c: R,
    /// One over half the difference of the eigenvalues, s.
    by_apart: R,
    /// Slope of `h phi1` between the eigenvalues, s^2.
    tilt: R,
    /// Slope of `phi1` where it is taken for the fast change.
    fast_by: R,
    /// The same of the slow change.
    slow_by: R,
}

impl<R: Real> Apart<R> {
    /// How a pressure follows the slopes: by mean and tilt, which follow the centre of the
    /// eigenvalues and what they are apart, and by half the difference of the outer slopes, which
    /// the tilt multiplies.
    #[inline(always)]
    fn by_slopes(&self, by_mean: R, by_tilt: R, by_half: R) -> [R; 4] {
        let &Self { h, half, b, c, by_apart, tilt, fast_by, slow_by } = self;
        let part = by_tilt * by_apart;
        let (on_fast, on_slow) = ((by_mean - part).times(0.5 * h), (by_mean + part).times(0.5 * h));
        let by_centre = (on_fast * fast_by + on_slow * slow_by).times(h);
        let by_distance = (on_slow * slow_by - on_fast * fast_by).times(h) - part * tilt;
        let spread = by_distance * by_apart;
        let by_half = by_half + spread * half;
        [
            (by_centre + by_half).times(0.5),
            (spread * c).times(0.5),
            (spread * b).times(0.5),
            (by_centre - by_half).times(0.5),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::FlowForm;
    use crate::numeric::Dual;

    /// Pressures after a step, from the numbers of [`Ends`], the tube's two, and the pressures.
    fn step<S: Scalar>(
        h: f64,
        [driven, slope, swelling, port, chamber, tau, laminar_pa, p, q]: [S; 9],
    ) -> [S; 2] {
        let flow = FlowFunction::new(0.3, FlowForm::Iso6358);
        let line = LineParameters { time_constant_s: tau, volume_ratio: port.recip(), laminar_pa };
        let ends = Ends { driven, slope, swelling, port, chamber };
        let tube = Tube { flow: &flow, line: &line };
        tube.advance(h, &ends, [p, q], tube.halfway(h, &ends, [p, q]))
    }

    /// Filling, venting, and almost without a drop, where the tube is stiffest.
    const PLACES: [[f64; 9]; 3] = [
        [3e5, -0.4, 0.1, 20.0, 0.9, 0.3, 8e3, 4e5, 3e5],
        [-2e5, -1.5, -0.2, 30.0, 1.1, 0.06, 0.0, 2e5, 2.5e5],
        [1e4, -0.1, 0.0, 50.0, 1.0, 0.1, 2e3, 3.001e5, 3e5],
    ];

    #[test]
    fn slopes_of_a_step_agree_with_central_differences() {
        for place in PLACES {
            let exact = step(0.004, std::array::from_fn(|k| Dual::<f64, 9>::variable(place[k], k)));
            for k in 0..9 {
                let by = 1e-6 * place[k].abs().max(0.1);
                let moved = |by: f64| {
                    let mut place = place;
                    place[k] += by;
                    step(0.004, place)
                };
                let (after, before) = (moved(by), moved(-by));
                for end in 0..2 {
                    let central = (after[end] - before[end]) / (2.0 * by);
                    let error = (exact[end].gradient[k] - central).abs();
                    // What rounding leaves of a difference of pressures.
                    let allowed = 1e-5 * central.abs() + 1e-9 / by;
                    assert!(
                        error < allowed,
                        "{place:?}: {end} by {k}: {} and not {central}",
                        exact[end].gradient[k]
                    );
                }
            }
        }
    }

    /// Second order: half the step, a quarter of the error.
    #[test]
    fn a_step_in_halves_is_as_much_nearer_as_its_order_says() {
        for place in PLACES {
            let in_parts = |parts: u32| {
                let mut place = place;
                for _ in 0..parts {
                    // The valve's flow is the line that it is at the start.
                    let [port, chamber] = step(0.004 / f64::from(parts), place);
                    place[0] += place[1] * (port - place[7]);
                    (place[7], place[8]) = (port, chamber);
                }
                [place[7], place[8]]
            };
            let fine = in_parts(1024);
            let errors = [4, 8].map(|parts| (in_parts(parts)[0] - fine[0]).abs());
            assert!(errors[0] < 0.02 * (fine[0] - place[7]).abs(), "{place:?}: {errors:?} Pa");
            assert!(errors[1] < 0.35 * errors[0], "{place:?}: {errors:?} Pa");
        }
    }
}
