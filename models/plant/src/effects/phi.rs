//! The functions of exponential integrators (Hochbruck and Ostermann, Acta Numerica 2010), over any kind of number.

use crate::numeric::{Real, Scalar};

/// `(exp(z) - 1) / z`.
#[inline(always)]
pub fn phi1<S: Scalar>(z: S) -> S {
    let x = z.real();
    // The next term is below 2e-10.
    let near = taylor(x, [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0]);
    let value = far_or(near, x, f64::exp_m1);
    // phi1' = phi1 - phi2, phi2 = (phi1 - 1) / z.
    let phi2 = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5];
    z.chain(value, value - next(value, 1.0, x, phi2))
}

/// The next of these functions from one, `(value - at_zero) / z`; by its Taylor series near zero. Arithmetic only, so that the compiler
/// removes it where derivatives are not wanted.
#[inline(always)]
pub fn next<R: Real>(value: R, at_zero: f64, z: R, series: [f64; 6]) -> R {
    let near = z.abs().below(R::constant(0.1));
    R::select(near, horner(z, series), value.plus(-at_zero) / z)
}

/// A polynomial of fifth degree, highest power first, by Estrin's scheme: a step of a simulation waits for it, and in Horner's order twice as
/// long.
#[inline(always)]
pub fn taylor<R: Real>(z: R, [a5, a4, a3, a2, a1, a0]: [f64; 6]) -> R {
    let pair = |high: f64, low: f64| z.times(high).plus(low);
    let squared = z * z;
    (pair(a5, a4) * squared + pair(a3, a2)) * squared + pair(a1, a0)
}

/// The same in Horner's order, which needs the fewest registers: for derivatives, which nothing waits for.
#[inline(always)]
fn horner<R: Real>(z: R, terms: [f64; 6]) -> R {
    let mut sum = R::zero();
    for term in terms {
        sum = (sum * z).plus(term);
    }
    sum
}

/// `near` where `z` is small, else `far(z) / z`, lane by lane.
#[inline(always)]
pub fn far_or<R: Real>(near: R, z: R, far: impl Fn(f64) -> f64) -> R {
    R::from_lanes(
        #[inline(always)]
        |k| {
            let z = z.lane(k);
            if z.abs() < 0.1 { near.lane(k) } else { far(z) / z }
        },
    )
}
