//! A function of few numbers inside a computation over numbers with many derivatives.

use super::{Dual, Scalar, filled};

/// A function's derivatives by its own arguments first, and from them those in all directions by
/// the chain rule: less work than the function itself over numbers with more derivatives than it
/// has arguments. Over plain numbers it is the function and nothing else.
///
/// Give the function `#[inline(always)]`.
#[inline(always)]
pub(crate) fn through<S: Scalar, const K: usize, const M: usize>(
    arguments: [S; K],
    function: impl FnOnce([Dual<S::Real, K>; K]) -> [Dual<S::Real, K>; M],
) -> [S; M] {
    let values = function(filled(
        Dual::from_real(S::Real::zero()),
        #[inline(always)]
        |k| Dual::variable(arguments[k].real(), k),
    ));
    filled(
        S::zero(),
        #[inline(always)]
        |m| S::chain_all(values[m].value, arguments, values[m].gradient),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both<S: Scalar>([a, b]: [S; 2]) -> [S; 2] {
        [(a * b).sqrt() + a, a / b]
    }

    #[test]
    fn derivatives_are_those_of_the_function_itself() {
        type Wide = Dual<f64, 3>;
        let a = Wide { value: 2.0, gradient: [1.0, 0.5, 0.0] };
        let b = Wide { value: 8.0, gradient: [0.0, 3.0, -1.0] };
        let (found, expected) = (through([a, b], both), both([a, b]));
        for (found, expected) in found.into_iter().zip(expected) {
            assert_eq!(found.value, expected.value);
            for (found, expected) in found.gradient.into_iter().zip(expected.gradient) {
                assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            }
        }
        assert_eq!(through([2.0, 8.0], both), [6.0, 0.25]);
    }
}
