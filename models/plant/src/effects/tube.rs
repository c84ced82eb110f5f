//! Two volumes with a tube between them: the port's, where the sensor sits, and the chamber's.
//!
//! The tube's flow over its drop is a conductance that changes slowly, though the drop may vanish:
//! with the conductance held, the two pressures are a linear system, whose step is exact for any
//! length and any stiffness (exponential midpoint rule, Hochbruck and Ostermann, Acta Numerica
//! 2010). What the conductance is in the middle of the step is told by half a step of the linearly
//! implicit Euler method, which needs no exponential.

use super::phi::phi1;
use crate::numeric::Scalar;

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

/// The pressures `[port, chamber]` after `h` seconds; `conductance` is the tube's between two
/// pressures, 1/s.
#[inline(always)]
pub fn advance<S: Scalar>(
    h: f64,
    ends: &Ends<S>,
    [port, chamber]: [S; 2],
    conductance: impl Fn(S, S) -> S,
) -> [S; 2] {
    // Rates and their slopes by the two pressures, with a conductance.
    let linear = |through: S| {
        let flow = through * (port - chamber);
        let rates = [(ends.driven - flow) * ends.port, flow * ends.chamber - ends.swelling * chamber];
        let onward = through * ends.chamber;
        let slopes = [(ends.slope - through) * ends.port, through * ends.port, onward, -onward - ends.swelling];
        (rates, slopes)
    };
    let ([x, y], [a, b, c, d]) = linear(conductance(port, chamber));
    // (1 - h/2 A) z = h/2 r, by Cramer's rule.
    let (left, right) = ((-a.times(0.5 * h)).plus(1.0), (-d.times(0.5 * h)).plus(1.0));
    let factor = (left * right - (b * c).times(0.25 * h * h)).recip().times(0.5 * h);
    let middle = [
        port + (right * x + (b * y).times(0.5 * h)) * factor,
        chamber + (left * y + (c * x).times(0.5 * h)) * factor,
    ];
    let ([x, y], [a, b, c, d]) = linear(conductance(middle[0], middle[1]));
    // Real eigenvalues: b c > 0.
    let (centre, half) = ((a + d).times(0.5), (a - d).times(0.5));
    let apart = (half.square() + b * c).plus(1e-6).sqrt();
    let (fast, slow) = (phi1((centre - apart).times(h)), phi1((centre + apart).times(h)));
    // phi1 of the matrix is the line through its values at the eigenvalues.
    let (mean, tilt) = ((fast + slow).times(0.5), (slow - fast) / apart.times(2.0));
    [
        port + (mean * x + tilt * (half * x + b * y)).times(h),
        chamber + (mean * y + tilt * (c * x - half * y)).times(h),
    ]
}
