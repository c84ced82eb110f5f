//! The firmware's ELF on the emulated chip, alone and with the host's bus.
//!
//! `cargo test -p system-tests --test firmware` builds it first, for its target.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod bus;
mod control_loop;
mod equivalence;
mod fast_bus;
mod fault_table;
mod i2c;
mod line_rate;
mod memory;
mod on_target;
mod pages;
mod parameters;
mod post_mortem;
mod reaction;
mod rig;
mod safety;
mod soak;
mod uf2;
mod update;
mod upsets;
