//! The functions of exponential integrators (Hochbruck and Ostermann, Acta Numerica 2010), over any
//! kind of number.

use crate::numeric::{Real, Scalar};

/// `(exp(z) - 1) / z`.
#[inline(always)]
pub fn phi1<S: Scalar>(z: S) -> S {
    let (value, slope) = phi1_with_slope(z.real());
    z.chain(value, slope)
}

/// The same with its slope.
#[inline(always)]
pub fn phi1_with_slope<R: Real>(x: R) -> (R, R) {
    // The next term is below 2e-10.
    let near = taylor(x, [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0]);
    let value = far_or(near, x, f64::exp_m1);
    // phi1' = phi1 - phi2, phi2 = (phi1 - 1) / z.
    let phi2 = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5];
    (value, value - next(value, 1.0, x, phi2))
}

/// The next of these functions from one, `(value - at_zero) / z`; by its Taylor series near zero.
/// Arithmetic only, so that the compiler removes it where derivatives are not wanted.
#[inline(always)]
pub fn next<R: Real>(value: R, at_zero: f64, z: R, series: [f64; 6]) -> R {
    let near = z.abs().below(R::constant(0.1));
    R::select(near, horner(z, series), value.plus(-at_zero) / z)
}

/// A polynomial of fifth degree, highest power first, by Estrin's scheme: a step of a simulation
/// waits for it, and in Horner's order twice as long.
#[inline(always)]
pub fn taylor<R: Real>(z: R, [a5, a4, a3, a2, a1, a0]: [f64; 6]) -> R {
    let pair = |high: f64, low: f64| z.times(high).plus(low);
    let squared = z * z;
    (pair(a5, a4) * squared + pair(a3, a2)) * squared + pair(a1, a0)
}

/// The same in Horner's order, which needs the fewest registers: for derivatives, which nothing
/// waits for.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;

    /// Where the series ends and the exponential begins, and on either side.
    #[test]
    fn phi1_and_its_slope_are_those_of_the_exponential() {
        for z in [-3.0, -0.5, -0.101, -0.099, -0.01, 0.003, 0.05, 0.0999, 0.1001, 1.0] {
            let value = f64::exp_m1(z) / z;
            let slope = (z.exp() - value) / z;
            let found = phi1(Dual::<f64, 1>::variable(z, 0));
            assert!((found.value - value).abs() < 3e-10, "phi1({z}): {} and not {value}", found.value);
            assert!(
                (found.gradient[0] - slope).abs() < 3e-9,
                "slope at {z}: {:?} and not {slope}",
                found.gradient
            );
        }
        assert_eq!(phi1(0.0), 1.0);
    }

    #[test]
    fn both_orders_of_a_polynomial_are_the_same_polynomial() {
        let terms = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0];
        // 3 z^5 - z^4 + 4 z^3 + z^2 - 5 z + 9 at 2: 96 - 16 + 32 + 4 - 10 + 9.
        assert_eq!([taylor(2.0, terms), horner(2.0, terms)], [115.0; 2]);
    }
}
