//! The plant against its page, closed forms, its effects one by one, and anything at random.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod docs;
mod effects;
mod physics;
mod robustness;
