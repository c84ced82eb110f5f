//! Fuzz targets. As ordinary tests they try some thousand inputs each, and every input that ever failed (kept in
//! `__fuzz__/` beside this file); longer, and guided by coverage:
//!
//! ```console
//! $ cargo test -p system-tests --test fuzz
//! $ BOLERO_RANDOM_ITERATIONS=1000000 cargo test -p system-tests --test fuzz
//! $ cargo install cargo-bolero && cargo bolero test -p system-tests --test fuzz -T 10m decoders::the_hosts_ear
//! ```
//!
//! A loader may refuse a file with an error that says something, or read it. Nothing may panic, overflow, or hang.

#![allow(clippy::unwrap_used)]

mod board;
mod chip;
mod decoders;
mod files;
mod models;
mod mutation;
mod recordings;

/// Up to so many bytes.
fn scripts(longest: usize) -> impl bolero::ValueGenerator<Output = Vec<u8>> {
    bolero::produce::<Vec<u8>>().with().len(0..=longest)
}
