//! What can be rolled out.

use crate::model::Parameter;
use crate::numeric::Scalar;

/// A dynamic system with `N` continuous states, a memory that changes at discrete instants, and `M` measured outputs.
///
/// One sample interval, from row `k` of a [`Series`](super::Series) to row `k + 1`, goes like this:
///
/// 1. [`measure`](System::measure) gives what the sensors read at row `k`;
/// 2. the interval is divided into [`ticks`](System::ticks) equal parts; at the start of each, [`hold`](System::hold) sees the
///    state, may change the memory (delay lines, hysteresis, a sampled controller) and returns what stays constant
///    during the tick;
/// 3. the state is integrated over the tick with [`derivative`](System::derivative).
///
/// Everything is generic over [`Scalar`] and dispatched statically; mark the methods `#[inline(always)]`, or lanes and vector
/// instructions are lost. Case distinctions on scalars are selects, not branches. What depends on nothing but the system
/// itself (an effect that is off) may branch freely.
pub trait System<const N: usize, const M: usize>: Sync {
    /// What depends on the parameters only.
    type Coefficients<S: Scalar>;

    /// What is carried from tick to tick beside the continuous states. Use `()` when there is none.
    type Memory<S: Scalar>;

    /// What is constant during one tick.
    type Held<S: Scalar>;

    /// The parameters in the order in which [`coefficients`](System::coefficients) takes them.
    fn parameters(&self) -> Vec<Parameter>;

    /// Prepares the parameters, given in their units.
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> Self::Coefficients<S>;

    /// Ticks per sample interval of the given nominal length, at least one.
    fn ticks(&self, interval_s: f64) -> usize {
        let _ = interval_s;
        1
    }

    /// States and memory at the start of a segment, where the pressures (absolute, Pa) are `pressures`.
    fn start<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        pressures: [S; M],
    ) -> ([S; N], Self::Memory<S>);

    /// Shows every number that is carried from tick to tick beside the continuous states, in an order that stays.
    fn values(memory: &mut Self::Memory<f64>, visit: &mut dyn FnMut(&mut f64)) {
        let _ = (memory, visit);
    }

    /// What the sensors read at this row, absolute, Pa.
    fn measure<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        state: &[S; N],
        memory: &mut Self::Memory<S>,
    ) -> [S; M];

    /// Prepares tick number `tick` of the interval that starts at this row.
    fn hold<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        tick: usize,
        state: &[S; N],
        memory: &mut Self::Memory<S>,
    ) -> Self::Held<S>;

    /// Rates of the states, per second.
    fn derivative<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        held: &Self::Held<S>,
        state: &[S; N],
    ) -> [S; N];
}
