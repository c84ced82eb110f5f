//! The kinds of numbers that channels are simulated over, each compiled here and once.

use multiversion::multiversion;

use super::catalogue::{AnyEffect, CATALOGUE};
use super::hook::Memory;
use super::inputs::ChannelInputs;
use super::plant::Plant;
use super::run::Run;
use crate::numeric::{Dual, Lanes, Scalar};

/// Derivatives that are simulated at a time; more take more simulations. Each number of them would
/// cost seconds of compilation.
pub const NARROW: usize = 8;
/// Derivatives that a fit of measured data simulates at a time: what a channel's model and two
/// effects have together.
pub const SENSITIVITIES: usize = 16;

/// A number with derivatives for fits of measured data. In single precision: seven digits of a
/// slope are more than any step of a fit needs, and sixteen of them take less time than eight in
/// double precision.
pub type Sensitive = Dual<f64, SENSITIVITIES, f32>;
/// The same with at most [`NARROW`] of them, which most models of a search and all disturbances of
/// blocks do with.
pub type NarrowSensitive = Dual<f64, NARROW, f32>;

/// A number that channels are simulated over: plain, in lanes, or with derivatives. What asks every
/// effect of the catalogue takes long to compile: each kind has one copy of it, in this crate,
/// whoever simulates. Callers use [`Stepper`](super::Stepper) and [`install`](super::install).
pub trait Simulated: Scalar {
    /// Effects, by their numbers in the catalogue, with the values of their parameters one after
    /// the other.
    #[doc(hidden)]
    fn installed(effects: &[usize], values: &[Self]) -> Vec<AnyEffect<Self>>;

    /// A channel before its first row.
    #[doc(hidden)]
    fn begun<'a>(
        plant: &'a Plant,
        base: &[Self],
        effects: &[AnyEffect<Self>],
        inputs: &'a ChannelInputs,
    ) -> Run<'a, Self>;

    /// Begins at rest at the pressure measured in a row.
    #[doc(hidden)]
    fn start(run: &mut Run<'_, Self>, row: usize, effects: &mut [AnyEffect<Self>]);

    /// What is recorded in a row, gauge, Pa.
    #[doc(hidden)]
    fn reading(run: &mut Run<'_, Self>, row: usize, effects: &mut [AnyEffect<Self>]) -> Self;

    /// One interval: the mean drive, and the mean flow drawn from the supply.
    #[doc(hidden)]
    fn interval(
        run: &mut Run<'_, Self>,
        row: usize,
        effects: &mut [AnyEffect<Self>],
    ) -> (Self::Real, Self::Real);

    /// Shows what channel and effects remember.
    #[doc(hidden)]
    fn memory(
        run: &mut Run<'_, Self>,
        effects: &mut [AnyEffect<Self>],
        visit: &mut dyn FnMut(Memory, &mut Self),
    );
}

macro_rules! simulated {
    ($($number:ty),* $(,)?) => { $(
        impl Simulated for $number {
            #[inline(never)]
            fn installed(effects: &[usize], values: &[Self]) -> Vec<AnyEffect<Self>> {
                let mut at = 0;
                effects
                    .iter()
                    .filter_map(|&effect| {
                        let next = at + CATALOGUE[effect].parameters.len();
                        let installed = AnyEffect::install(effect, &values[at..next]);
                        at = next;
                        installed
                    })
                    .collect()
            }

            #[inline(never)]
            fn begun<'a>(
                plant: &'a Plant,
                base: &[Self],
                effects: &[AnyEffect<Self>],
                inputs: &'a ChannelInputs,
            ) -> Run<'a, Self> {
                Run::new(plant, base, effects, inputs)
            }

            #[inline(never)]
            fn start(run: &mut Run<'_, Self>, row: usize, effects: &mut [AnyEffect<Self>]) {
                for effect in effects {
                    effect.reset();
                }
                run.start(row);
            }

            #[inline(never)]
            fn reading(run: &mut Run<'_, Self>, row: usize, effects: &mut [AnyEffect<Self>]) -> Self {
                let reported = run.report();
                effects.iter_mut().fold(reported, |reading, effect| effect.sample(run.inputs, row, reading))
            }

            // Vectors of plain numbers or of derivatives have another copy for processors with
            // wider registers.
            #[inline(never)]
            fn interval(
                run: &mut Run<'_, Self>,
                row: usize,
                effects: &mut [AnyEffect<Self>],
            ) -> (Self::Real, Self::Real) {
                if Self::WIDE { wide_interval(run, row, effects) } else { run.interval(row, effects) }
            }

            #[inline(never)]
            fn memory(
                run: &mut Run<'_, Self>,
                effects: &mut [AnyEffect<Self>],
                visit: &mut dyn FnMut(Memory, &mut Self),
            ) {
                run.memory(visit);
                for effect in effects {
                    effect.memory(visit);
                }
            }
        }
    )* };
}

simulated!(f64, Lanes<4>, Dual<f64, 4>, Dual<f64, NARROW>, NarrowSensitive, Sensitive);

#[multiversion(targets("x86_64+avx2"))]
fn wide_interval<S: Scalar>(
    run: &mut Run<'_, S>,
    row: usize,
    effects: &mut [AnyEffect<S>],
) -> (S::Real, S::Real) {
    run.interval(row, effects)
}
