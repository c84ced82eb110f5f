//! The live page, as browsers and strangers use it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod deadman;
mod hostile;
mod requests;
mod support;
