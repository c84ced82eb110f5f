//! Independent values in lockstep.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Real, Scalar, filled};

/// `L` independent values in lockstep. Plain loops over an array: the compiler turns them into vector instructions.
/// Each lane gives bit for bit what `f64` gives. Aligned to a cache line: a vector across two of them takes two loads.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Lanes<const L: usize>(pub [f64; L]);

impl<const L: usize> Lanes<L> {
    #[inline(always)]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        Self(filled(
            0.0,
            #[inline(always)]
            |i| f(self.0[i]),
        ))
    }

    #[inline(always)]
    fn zip(self, other: Self, mut f: impl FnMut(f64, f64) -> f64) -> Self {
        Self(filled(
            0.0,
            #[inline(always)]
            |i| f(self.0[i], other.0[i]),
        ))
    }
}

impl<const L: usize> Add for Lanes<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a + b,
        )
    }
}

impl<const L: usize> Sub for Lanes<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a - b,
        )
    }
}

impl<const L: usize> Mul for Lanes<L> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a * b,
        )
    }
}

impl<const L: usize> Div for Lanes<L> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(
            other,
            #[inline(always)]
            |a, b| a / b,
        )
    }
}

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(
            #[inline(always)]
            |a| -a,
        )
    }
}

impl<const L: usize> Scalar for Lanes<L> {
    type Real = Self;
    const WIDE: bool = true;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; L])
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

    #[inline(always)]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    #[inline(always)]
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
    fn select(mask: [u64; L], a: Self, b: Self) -> Self {
        Self(filled(
            0.0,
            #[inline(always)]
            |i| f64::from_bits((a.0[i].to_bits() & mask[i]) | (b.0[i].to_bits() & !mask[i])),
        ))
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
        self.map(f64::abs)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        self.map(f64::exp)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.map(f64::ln)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.map(f64::sin)
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.map(f64::cos)
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        self.map(f64::tanh)
    }
}

impl<const L: usize> Real for Lanes<L> {
    /// All bits of a lane set, or none: a select is then two ands and an or.
    type Mask = [u64; L];
    const LANES: usize = L;

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self {
        Self(filled(0.0, value))
    }

    #[inline(always)]
    fn below(self, other: Self) -> [u64; L] {
        filled(
            0,
            #[inline(always)]
            |i| if self.0[i] < other.0[i] { u64::MAX } else { 0 },
        )
    }

    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        self.zip(sign, f64::copysign)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.map(f64::floor)
    }

    #[inline(always)]
    fn both(a: [u64; L], b: [u64; L]) -> [u64; L] {
        filled(
            0,
            #[inline(always)]
            |i| a[i] & b[i],
        )
    }

    #[inline(always)]
    fn not(mask: [u64; L]) -> [u64; L] {
        filled(
            0,
            #[inline(always)]
            |i| !mask[i],
        )
    }
}
