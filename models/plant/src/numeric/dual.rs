//! Forward-mode automatic differentiation.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Real, Scalar, filled};

/// A value with its derivatives in `N` directions. The value is bit for bit what the plain number gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<T, const N: usize> {
    /// The value.
    pub value: T,
    /// Its derivative in each direction.
    pub gradient: [T; N],
}

impl<T: Real, const N: usize> Dual<T, N> {
    /// The variable of one direction: derivative one there and zero elsewhere. `direction >= N` gives a constant.
    #[inline(always)]
    pub fn variable(value: T, direction: usize) -> Self {
        let mut variable = Self::from_real(value);
        if let Some(slope) = variable.gradient.get_mut(direction) {
            *slope = T::constant(1.0);
        }
        variable
    }
}

impl<T: Real, const N: usize> Add for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: filled(
                T::zero(),
                #[inline(always)]
                |i| self.gradient[i] + other.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize> Sub for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            gradient: filled(
                T::zero(),
                #[inline(always)]
                |i| self.gradient[i] - other.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize> Mul for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::chain2(self.value * other.value, self, other.value, other, self.value)
    }
}

impl<T: Real, const N: usize> Div for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = T::constant(1.0) / other.value;
        Self::chain2(quotient, self, inverse, other, -(quotient * inverse))
    }
}

impl<T: Real, const N: usize> Neg for Dual<T, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            value: -self.value,
            gradient: filled(
                T::zero(),
                #[inline(always)]
                |i| -self.gradient[i],
            ),
        }
    }
}

impl<T: Real, const N: usize> Scalar for Dual<T, N> {
    type Real = T;
    const WIDE: bool = true;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::from_real(T::constant(value))
    }

    #[inline(always)]
    fn from_real(value: T) -> Self {
        Self { value, gradient: [T::zero(); N] }
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
        Self {
            value,
            gradient: filled(
                T::zero(),
                #[inline(always)]
                |i| self.gradient[i] * slope,
            ),
        }
    }

    #[inline(always)]
    fn chain2(value: T, a: Self, partial_a: T, b: Self, partial_b: T) -> Self {
        Self {
            value,
            gradient: filled(
                T::zero(),
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
                T::zero(),
                #[inline(always)]
                |i| T::select(mask, a.gradient[i], b.gradient[i]),
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
