//! The toolkit's library, as its users meet it.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod effects;
mod engine;
mod own_tables;
