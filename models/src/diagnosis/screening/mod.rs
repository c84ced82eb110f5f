//! The whole catalogue tried at low cost: score tests of probes, cycles found by their period.

mod asked;
mod cycles;
mod pairs;
mod periodogram;
mod probe;
mod score_test;
mod scores;
mod thinning;

pub use asked::{Asked, applicable};
pub use pairs::{Pair, promising_pairs};
pub use probe::{Probing, Trial};
pub use score_test::{Gate, judge, trials};
pub use scores::scores;
