//! The board's law and its service of the bus, as the firmware uses them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod bus;
mod common;
mod edges;
mod i2c_sensors;
mod line_rate;
mod loop_rate;
mod original_defects;
mod pages;
mod properties;
mod safety;
mod session;
