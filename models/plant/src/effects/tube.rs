//! Two volumes with a tube between them: the port's, where the sensor sits, and the chamber's.
//!
//! The tube's flow over its drop is a conductance that changes slowly, though the drop may vanish:
//! with the conductance held, the two pressures are a linear system, whose step is exact for any
//! length and any stiffness (exponential Euler, Hochbruck and Ostermann, Acta Numerica 2010). The
//! step is made twice, the second time with the conductance of its middle.

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
    let step = |through: S| {
        let flow = through * (port - chamber);
        let rates = [(ends.driven - flow) * ends.port, flow * ends.chamber - ends.swelling * chamber];
        let (a, b) = ((ends.slope - through) * ends.port, through * ends.port);
        let (c, d) = (through * ends.chamber, -(through * ends.chamber) - ends.swelling);
        // Real eigenvalues: b c > 0.
        let (middle, half) = ((a + d).times(0.5), (a - d).times(0.5));
        let apart = (half.square() + b * c).plus(1e-6).sqrt();
        let (fast, slow) = (phi1((middle - apart).times(h)), phi1((middle + apart).times(h)));
        // phi1 of the matrix is the line through its values at the eigenvalues.
        let (mean, tilt) = ((fast + slow).times(0.5), (slow - fast) / apart.times(2.0));
        let [x, y] = rates;
        [
            port + (mean * x + tilt * (half * x + b * y)).times(h),
            chamber + (mean * y + tilt * (c * x - half * y)).times(h),
        ]
    };
    let first = step(conductance(port, chamber));
    step(conductance((port + first[0]).times(0.5), (chamber + first[1]).times(0.5)))
}
