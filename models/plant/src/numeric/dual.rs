//! Forward-mode automatic differentiation.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Arithmetic, Real, Scalar, filled};

/// A value with its derivatives in `N` directions. The value is bit for bit what the plain number
/// gives; derivatives may be of another precision `G`: twice as many `f32` as `f64` are in a
/// vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<T, const N: usize, G = T> {
    /// The value.
    pub value: T,
    /// Its derivative in each direction.
    pub gradient: [G; N],
}

/// What the derivatives of numbers over `T` are held in.
pub trait Slope<T: Real>: Arithmetic + PartialEq {
    /// The nearest slope.
    fn of(slope: T) -> Self;

    /// `a` where the mask holds, `b` elsewhere.
    fn pick(mask: T::Mask, a: Self, b: Self) -> Self;
}

impl<T: Real> Slope<T> for T {
    #[inline(always)]
    fn of(slope: T) -> Self {
        slope
    }

    #[inline(always)]
    fn pick(mask: T::Mask, a: Self, b: Self) -> Self {
        T::select(mask, a, b)
    }
}

impl Slope<f64> for f32 {
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation)] // that is what it is for
    fn of(slope: f64) -> Self {
        slope as Self
    }

    #[inline(always)]
    fn pick(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Dual<T, N, G> {
    /// The variable of one direction: derivative one there and zero elsewhere. `direction >= N`
    /// gives a constant.
    #[inline(always)]
    pub fn variable(value: T, direction: usize) -> Self {
        let mut variable = Self::from_real(value);
        if let Some(slope) = variable.gradient.get_mut(direction) {
            *slope = G::of(T::constant(1.0));
        }
        variable
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Add for Dual<T, N, G> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| self.gradient[i] + other.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Sub for Dual<T, N, G> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| self.gradient[i] - other.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Mul for Dual<T, N, G> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::chain2(self.value * other.value, self, other.value, other, self.value)
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Div for Dual<T, N, G> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = T::constant(1.0) / other.value;
        Self::chain2(quotient, self, inverse, other, -(quotient * inverse))
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Neg for Dual<T, N, G> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| -self.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize, G: Slope<T>> Scalar for Dual<T, N, G> {
    type Real = T;
    const WIDE: bool = true;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::from_real(T::constant(value))
    }

    #[inline(always)]
    fn from_real(value: T) -> Self {
        Self { value, gradient: [G::of(T::zero()); N] }
    }

    #[inline(always)]
    fn real(self) -> T {
        self.value
    }

    #[inline(always)]
    fn with_real(self, value: T) -> Self {
        Self { value, gradient: self.gradient }
    }

    #[inline(always)]
    fn scale(self, factor: T) -> Self {
        self.chain(self.value * factor, factor)
    }

    #[inline(always)]
    fn shift(self, offset: T) -> Self {
        Self { value: self.value + offset, gradient: self.gradient }
    }

    #[inline(always)]
    fn chain(self, value: T, slope: T) -> Self {
        let slope = G::of(slope);
        Self {
            value,
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| self.gradient[i] * slope,
            ),
        }
    }

    #[inline(always)]
    fn chain2(value: T, a: Self, partial_a: T, b: Self, partial_b: T) -> Self {
        let (partial_a, partial_b) = (G::of(partial_a), G::of(partial_b));
        Self {
            value,
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| a.gradient[i] * partial_a + b.gradient[i] * partial_b,
            ),
        }
    }

    #[inline(always)]
    fn select(mask: T::Mask, a: Self, b: Self) -> Self {
        Self {
            value: T::select(mask, a.value, b.value),
            gradient: filled(
                G::of(T::zero()),
                #[inline(always)]
                |i| G::pick(mask, a.gradient[i], b.gradient[i]),
            ),
        }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, T::constant(0.5) / root)
    }

    #[inline(always)]
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }

    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), T::constant(1.0) / self.value)
    }

    #[inline(always)]
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    #[inline(always)]
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }

    #[inline(always)]
    fn tanh(self) -> Self {
        let value = self.value.tanh();
        self.chain(value, T::constant(1.0) - value * value)
    }
}
