//! What everything that is counted with here can do.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, a vector of them or a slope: copied, shared between threads, added, subtracted,
/// multiplied, divided and negated.
pub trait Arithmetic:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl<T> Arithmetic for T where
    T: Copy
        + Debug
        + Send
        + Sync
        + 'static
        + Add<Output = T>
        + Sub<Output = T>
        + Mul<Output = T>
        + Div<Output = T>
        + Neg<Output = T>
{
}
