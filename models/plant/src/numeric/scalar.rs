//! What a right-hand side may do with its numbers.

use std::fmt::Debug;

use super::Arithmetic;

/// The result of a comparison: `bool`, or one truth value per lane.
pub type Mask<S> = <<S as Scalar>::Real as Real>::Mask;

/// A number a model is evaluated over. Comparisons look at values only, never at derivatives; there
/// is no branch on a lane, so a case distinction is a [`select`](Scalar::select) between two
/// computed values.
pub trait Scalar: Arithmetic {
    /// The same number without derivatives; measured inputs have this type.
    type Real: Real;

    /// Is it several plain numbers, which vector instructions work on?
    const WIDE: bool;

    /// A number that does not depend on any parameter.
    fn constant(value: f64) -> Self;

    /// A number (per lane) that does not depend on any parameter.
    fn from_real(value: Self::Real) -> Self;

    /// The value without its derivatives.
    fn real(self) -> Self::Real;

    /// This number with its value replaced and its derivatives kept: how rounding is passed through
    /// (the derivative of a staircase is zero almost everywhere and useless to a fit).
    fn with_real(self, value: Self::Real) -> Self;

    /// Product with a number that has no derivatives; cheaper than `self * from_real(factor)`.
    fn scale(self, factor: Self::Real) -> Self;

    /// Sum with a number that has no derivatives.
    fn shift(self, offset: Self::Real) -> Self;

    /// The value of a function of this number whose derivative is known in closed form.
    fn chain(self, value: Self::Real, slope: Self::Real) -> Self;

    /// The value of a function of two numbers whose partial derivatives are known in closed form.
    fn chain2(value: Self::Real, a: Self, partial_a: Self::Real, b: Self, partial_b: Self::Real) -> Self;

    /// The value of a function of several numbers whose partial derivatives are known in closed
    /// form.
    #[inline(always)]
    fn chain_all<const K: usize>(value: Self::Real, numbers: [Self; K], partials: [Self::Real; K]) -> Self {
        let one = Self::Real::constant(1.0);
        let mut sum = Self::from_real(value);
        let mut k = 0;
        while k < K {
            sum = if k == 0 {
                numbers[k].chain(value, partials[k])
            } else {
                Self::chain2(value, sum, one, numbers[k], partials[k])
            };
            k += 1;
        }
        sum
    }

    /// `a` where the mask holds, `b` elsewhere.
    fn select(mask: Mask<Self>, a: Self, b: Self) -> Self;

    /// Square root. The derivative at zero is infinite.
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

    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    /// Product with a constant.
    #[inline(always)]
    fn times(self, factor: f64) -> Self {
        self.scale(Self::Real::constant(factor))
    }

    /// Sum with a constant.
    #[inline(always)]
    fn plus(self, offset: f64) -> Self {
        self.shift(Self::Real::constant(offset))
    }

    /// `1 / self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::constant(1.0) / self
    }

    /// `self * self`.
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }

    /// `self` to a power that may carry derivatives; `self` must be positive.
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }

    /// The sum with a change that is much smaller. In single precision `lost` keeps what rounding
    /// took from it, for the next time.
    #[inline(always)]
    fn accumulate(self, change: Self, _lost: &mut Self) -> Self {
        self + change
    }

    /// Is the value smaller than the other's?
    #[inline(always)]
    fn less(self, other: Self) -> Mask<Self> {
        self.real().below(other.real())
    }

    /// The smaller of the two, with its derivatives.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.less(other), self, other)
    }

    /// The larger of the two, with its derivatives.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.less(self), self, other)
    }

    /// Absolute value; the derivative at zero is taken from the right.
    #[inline(always)]
    fn abs(self) -> Self {
        Self::select(self.less(Self::zero()), -self, self)
    }
}

/// A [`Scalar`] without derivatives: `f64`, or several of them in lanes.
pub trait Real: Scalar<Real = Self> + PartialEq {
    /// One truth value per lane.
    type Mask: Copy + Debug + Send + Sync;

    /// How many independent values this is.
    const LANES: usize;

    /// The value in one lane, `lane < LANES`.
    fn lane(self, lane: usize) -> f64;

    /// A number whose lanes are given by a function of the lane's index.
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self;

    /// Lane by lane: is `self < other`?
    fn below(self, other: Self) -> Self::Mask;

    /// The magnitude of this number with the sign of another.
    fn with_sign_of(self, sign: Self) -> Self;

    /// Largest integer not above the value.
    fn floor(self) -> Self;

    /// Both masks hold.
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// The mask does not hold.
    fn not(mask: Self::Mask) -> Self::Mask;

    /// Nearest integer, halves upwards.
    #[inline(always)]
    fn round_half_up(self) -> Self {
        self.plus(0.5).floor()
    }
}
