//! The protocol, as hosts and boards use it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod checked;
mod decoders;
mod electronics;
mod false_address;
mod frozen;
mod line_rate;
mod pages;
mod parameters;
mod residual_error_rate;
mod sensors;
mod session;
mod session_distance;
mod update;
mod wire_format;
