//! The engine: numbers, models, rollouts and fits. One program, because every simulated system
//! takes long to compile.

#![allow(clippy::single_range_in_vec_init)] // one segment that covers all rows

mod batch;
mod cancel;
mod coverage;
mod derivatives;
mod fit_oracle;
mod gradient;
mod oracle;
mod recovery;
mod rollout_oracle;
mod single;
mod support;
