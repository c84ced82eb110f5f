//! Fuzz targets. As ordinary tests they try some thousand inputs each, and every input that ever
//! failed (kept in `__fuzz__/` beside this file); longer:
//!
//! ```console
//! $ cargo test -p system-tests --test fuzz
//! $ BOLERO_RANDOM_ITERATIONS=1000000 cargo test -p system-tests --test fuzz
//! ```
//!
//! Guided by coverage, by libFuzzer (which needs a C++ compiler), on the stable compiler. The
//! target folder is one of its own, because everything is built with counters:
//!
//! ```console
//! $ export CARGO_TARGET_DIR=target/libfuzzer
//! $ export RUSTFLAGS="--cfg fuzzing --cfg fuzzing_libfuzzer -Ccodegen-units=1 -Clink-dead-code \
//!     -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
//!     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
//!     -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares"
//! $ export BOLERO_LIBFUZZER_ARGS="-max_total_time=600"
//! $ cargo test --target x86_64-unknown-linux-gnu -p system-tests --test fuzz -- \
//!     --exact decoders::the_hosts_ear --nocapture
//! ```
//!
//! A loader may refuse a file with an error that says something, or read it. Nothing may panic,
//! overflow, or hang.

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
