//! The floating-point numbers that lanes are made of.

use std::fmt::Debug;
use std::ops::{BitAnd, Not};

use super::Arithmetic;

/// `f64` or `f32`.
pub trait Float: Arithmetic + PartialOrd {
    /// Its bits: all of them or none stand for a truth value.
    type Bits: Copy + Debug + Send + Sync + BitAnd<Output = Self::Bits> + Not<Output = Self::Bits>;

    /// Zero.
    const ZERO: Self;
    /// True.
    const ALL_BITS: Self::Bits;
    /// False.
    const NO_BITS: Self::Bits;
    /// Are sums of a large and a small number to be compensated for what rounding loses?
    const COMPENSATED: bool;

    /// The nearest number.
    fn from_f64(value: f64) -> Self;
    /// The same number.
    fn from_f32(value: f32) -> Self;
    /// The same number.
    fn to_f64(self) -> f64;
    /// `a` where all bits of the mask are set, `b` where none is.
    fn pick(mask: Self::Bits, a: Self, b: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Natural exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine of an angle in rad.
    fn sin(self) -> Self;
    /// Cosine of an angle in rad.
    fn cos(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Largest integer not above it.
    fn floor(self) -> Self;
    /// Its magnitude with the sign of another.
    fn copysign(self, sign: Self) -> Self;
}

macro_rules! floats {
    ($($float:ident, $bits:ident, $compensated:literal;)*) => { $(
        impl Float for $float {
            type Bits = $bits;
            const ZERO: Self = 0.0;
            const ALL_BITS: $bits = $bits::MAX;
            const NO_BITS: $bits = 0;
            const COMPENSATED: bool = $compensated;

            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, trivial_numeric_casts)]
            fn from_f64(value: f64) -> Self {
                value as $float
            }

            #[inline(always)]
            #[allow(clippy::useless_conversion)] // of f32
            fn from_f32(value: f32) -> Self {
                value.into()
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            fn pick(mask: $bits, a: Self, b: Self) -> Self {
                $float::from_bits((a.to_bits() & mask) | (b.to_bits() & !mask))
            }

            floats!($float: abs, sqrt, exp, ln, sin, cos, tanh, floor);

            #[inline(always)]
            fn copysign(self, sign: Self) -> Self {
                $float::copysign(self, sign)
            }
        }
    )* };
    ($float:ident: $($function:ident),*) => { $(
        #[inline(always)]
        fn $function(self) -> Self {
            $float::$function(self)
        }
    )* };
}

floats! {
    f64, u64, false;
    f32, u32, true;
}
