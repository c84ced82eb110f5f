//! The smooth corner of a valve's opening.

use crate::numeric::Scalar;

/// `max(x, 0)` with its corner rounded over the width `e`: `(sqrt(x^2 + e^2) + x) / 2`.
///
/// The paper prints `e = 1`, which adds half a unit of whatever `x` is measured in; here the width is a parameter in the
/// unit of `x`.
#[inline(always)]
pub fn smooth_corner<S: Scalar>(x: S, width: S) -> S {
    ((x.square() + width.square()).sqrt() + x).times(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corner_is_half_its_width_high_and_dies_out() {
        assert_eq!(smooth_corner(0.0, 0.2), 0.1);
        assert!((smooth_corner(10.0, 0.1) - 10.000_25).abs() < 1e-8);
        assert!((smooth_corner(-10.0, 0.1) - 0.000_25).abs() < 1e-8);
    }
}
