//! Numbers the models are written over: plain, with exact derivatives, in lockstep lanes, or both.
//!
//! A right-hand side is written once over [`Scalar`] and then evaluated as
//!
//! * `f64`: one value;
//! * [`Dual`]`<f64, N>`: a value and its derivatives in `N` directions (forward mode, exact to
//!   rounding);
//! * [`Dual`]`<f64, N, f32>`: the same with derivatives in single precision, twice as many in a
//!   vector;
//! * [`Lanes`]`<L>`: `L` independent values in lockstep, which the compiler turns into vector
//!   instructions;
//! * [`Lanes`]`<L, f32>`: the same in single precision, twice as many in a vector;
//! * [`Dual`]`<Lanes<L>, N>`: lanes with derivatives;
//! * [`Active`]: the same with derivatives by the measured inputs, too.

mod active;
mod arithmetic;
mod array;
mod dual;
mod float;
mod lanes;
mod plain;
mod scalar;

pub use active::Active;
pub use arithmetic::Arithmetic;
pub(crate) use array::filled;
pub use dual::{Dual, Slope};
pub use float::Float;
pub use lanes::Lanes;
pub use scalar::{Mask, Real, Scalar};
