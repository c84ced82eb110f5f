//! The toolkit on recordings of the truth plant, of virtual boards and of strangers.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod blind_rounds;
mod diagnosis_loop;
mod extended_round_trip;
mod measured_drive;
mod measured_supply;
mod regulators;
mod truth_is_the_model;
mod watch_loop;
