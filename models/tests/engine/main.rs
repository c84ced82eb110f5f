//! The engine: numbers, models, rollouts and fits. One program, because every simulated system takes long to compile.

#![allow(clippy::unwrap_used)]

mod batch;
mod coverage;
mod derivatives;
mod fit_oracle;
mod oracle;
mod recovery;
mod rollout_oracle;
mod support;
