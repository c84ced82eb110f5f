//! Numbers whose measured inputs have derivatives, too.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Dual, Real, Scalar, filled};

/// A [`Dual`] that is its own [`Real`](Scalar::Real): an active variable, as differentiation calls
/// it. Of a [`Dual`] only parameters and states have derivatives; a model over these numbers also
/// carries those by its row of inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Active<T, const N: usize>(pub Dual<T, N>);

macro_rules! operators {
    ($($operator:ident, $function:ident;)*) => { $(
        impl<T: Real, const N: usize> $operator for Active<T, N> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )* };
}

operators! {
    Add, add;
    Sub, sub;
    Mul, mul;
    Div, div;
}

impl<T: Real, const N: usize> Neg for Active<T, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<T: Real, const N: usize> Scalar for Active<T, N> {
    type Real = Self;
    const WIDE: bool = true;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self(Dual::constant(value))
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
        Self(self.0.with_real(value.0.value))
    }

    #[inline(always)]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    #[inline(always)]
    fn shift(self, offset: Self) -> Self {
        self + offset
    }

    /// The value was computed from numbers with derivatives, and has its own.
    #[inline(always)]
    fn chain(self, value: Self, _slope: Self) -> Self {
        value
    }

    #[inline(always)]
    fn chain2(value: Self, _a: Self, _partial_a: Self, _b: Self, _partial_b: Self) -> Self {
        value
    }

    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Self(Dual::select(mask, a.0, b.0))
    }

    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        Self(self.0.times(factor))
    }

    #[inline(always)]
    fn plus(self, offset: f64) -> Self {
        Self(self.0.plus(offset))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn exp(self) -> Self {
        Self(self.0.exp())
    }

    #[inline(always)]
    fn ln(self) -> Self {
        Self(self.0.ln())
    }

    #[inline(always)]
    fn sin(self) -> Self {
        Self(self.0.sin())
    }

    #[inline(always)]
    fn cos(self) -> Self {
        Self(self.0.cos())
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        Self(self.0.tanh())
    }
}

impl<T: Real, const N: usize> Real for Active<T, N> {
    type Mask = T::Mask;
    const LANES: usize = T::LANES;

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0.value.lane(lane)
    }

    #[inline(always)]
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self {
        Self(Dual::from_real(T::from_lanes(value)))
    }

    #[inline(always)]
    fn below(self, other: Self) -> T::Mask {
        self.0.value.below(other.0.value)
    }

    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        let one = T::constant(1.0);
        let flip = one.with_sign_of(self.0.value) * one.with_sign_of(sign.0.value);
        Self(Dual {
            value: self.0.value.with_sign_of(sign.0.value),
            gradient: filled(
                T::zero(),
                #[inline(always)]
                |i| self.0.gradient[i] * flip,
            ),
        })
    }

    /// A staircase: no derivatives.
    #[inline(always)]
    fn floor(self) -> Self {
        Self(Dual::from_real(self.0.value.floor()))
    }

    #[inline(always)]
    fn both(a: T::Mask, b: T::Mask) -> T::Mask {
        T::both(a, b)
    }

    #[inline(always)]
    fn not(mask: T::Mask) -> T::Mask {
        T::not(mask)
    }
}
