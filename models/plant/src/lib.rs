#![doc = include_str!("../README.md")]
//! # Modules
//!
//! * [`numeric`]: the numbers that everything is written over: plain, with exact derivatives, in
//!   lanes;
//! * [`model`]: the pressure models;
//! * [`board`]: the board that drives a valve: its sensor and its controller;
//! * [`rollout`]: simulating models, alone, behind the board's controller, or thousands at once;
//! * [`effects`]: the catalogue of physical effects, and channels simulated with them;
//! * [`parallel`]: work shared between cores.

pub mod board;
pub mod effects;
pub mod model;
pub mod numeric;
pub mod parallel;
pub mod rollout;
