//! Independent values in lockstep.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Float, Real, Scalar, filled};

/// `L` independent values in lockstep. Plain loops over an array: the compiler turns them into
/// vector instructions. Each lane gives bit for bit what its [`Float`] gives. Aligned to a cache
/// line: a vector across two of them takes two loads.
///
/// Arithmetic is not told to be inlined always, as everything else here: it is small enough to be
/// inlined anyway, and is then optimised once before, not at each place where it ends. That halves
/// the time it takes to compile the kernels.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const L: usize, T = f64>(pub [T; L]);

impl<const L: usize, T: Float> Lanes<L, T> {
    #[inline(always)]
    fn map(self, mut f: impl FnMut(T) -> T) -> Self {
        Self(filled(
            T::ZERO,
            #[inline(always)]
            |i| f(self.0[i]),
        ))
    }

    #[inline(always)]
    fn zip(self, other: Self, mut f: impl FnMut(T, T) -> T) -> Self {
        Self(filled(
            T::ZERO,
            #[inline(always)]
            |i| f(self.0[i], other.0[i]),
        ))
    }
}

impl<const L: usize, T: Float> Add for Lanes<L, T> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a + b,
        )
    }
}

impl<const L: usize, T: Float> Sub for Lanes<L, T> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a - b,
        )
    }
}

impl<const L: usize, T: Float> Mul for Lanes<L, T> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a * b,
        )
    }
}

impl<const L: usize, T: Float> Div for Lanes<L, T> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a / b,
        )
    }
}

impl<const L: usize, T: Float> Neg for Lanes<L, T> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        self.map(
            #[inline(always)]
            |a| -a,
        )
    }
}

impl<const L: usize, T: Float> Scalar for Lanes<L, T> {
    type Real = Self;
    const WIDE: bool = true;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([T::from_f64(value); L])
    }

    #[inline(always)]
    fn from_real(value: Self) -> Self {
        value
    }

    #[inline(always)]
    fn real(self) -> Self {
        self
    }

    #[inline(always)]
    fn with_real(self, value: Self) -> Self {
        value
    }

    #[inline]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    #[inline]
    fn shift(self, offset: Self) -> Self {
        self + offset
    }

    #[inline(always)]
    fn chain(self, value: Self, _slope: Self) -> Self {
        value
    }

    #[inline(always)]
    fn chain2(value: Self, _a: Self, _partial_a: Self, _b: Self, _partial_b: Self) -> Self {
        value
    }

    #[inline(always)]
    fn select(mask: [T::Bits; L], a: Self, b: Self) -> Self {
        Self(filled(
            T::ZERO,
            #[inline(always)]
            |i| T::pick(mask[i], a.0[i], b.0[i]),
        ))
    }

    /// Kahan's summation: without it a slow leak moves the pressure by less than half of its last
    /// digit a step, and not at all.
    #[inline(always)]
    fn accumulate(self, change: Self, lost: &mut Self) -> Self {
        if !T::COMPENSATED {
            return self + change;
        }
        let change = change - *lost;
        let sum = self + change;
        *lost = (sum - self) - change;
        sum
    }

    // The defaults compare and select; these are one instruction each.

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if a < b { a } else { b },
        )
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if b < a { a } else { b },
        )
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(T::abs)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(T::sqrt)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        self.map(T::exp)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.map(T::ln)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.map(T::sin)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.map(T::cos)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        self.map(T::tanh)
    }
}

impl<const L: usize, T: Float> Real for Lanes<L, T> {
    /// All bits of a lane set, or none: a select is then two ands and an or.
    type Mask = [T::Bits; L];
    const LANES: usize = L;

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane].to_f64()
    }

    #[inline(always)]
    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        Self(filled(
            T::ZERO,
            #[inline(always)]
            |i| T::from_f64(value(i)),
        ))
    }

    #[inline(always)]
    fn below(self, other: Self) -> [T::Bits; L] {
        filled(
            T::NO_BITS,
            #[inline(always)]
            |i| if self.0[i] < other.0[i] { T::ALL_BITS } else { T::NO_BITS },
        )
    }

    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        self.zip(sign, T::copysign)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.map(T::floor)
    }

    #[inline(always)]
    fn both(a: [T::Bits; L], b: [T::Bits; L]) -> [T::Bits; L] {
        filled(
            T::NO_BITS,
            #[inline(always)]
            |i| a[i] & b[i],
        )
    }

    #[inline(always)]
    fn not(mask: [T::Bits; L]) -> [T::Bits; L] {
        filled(
            T::NO_BITS,
            #[inline(always)]
            |i| !mask[i],
        )
    }
}
