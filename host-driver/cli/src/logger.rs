//! What the library says beside its results: warnings, and with RUST_LOG more.

use std::io::Write as _;

/// Warnings and errors go to standard error; RUST_LOG asks for more or less, as `RUST_LOG=debug` or
/// `RUST_LOG=pneudrive_host::line=trace`.
pub fn install() {
    let environment = env_logger::Env::default().default_filter_or("warn");
    // Nobody else has set a logger, this early in the program.
    let _ = env_logger::Builder::from_env(environment).format(line).try_init();
}

/// `warning: ..` as all that the program says; what is finer also says who says it.
fn line(out: &mut env_logger::fmt::Formatter, record: &log::Record<'_>) -> std::io::Result<()> {
    match record.level() {
        log::Level::Error => writeln!(out, "error: {}", record.args()),
        log::Level::Warn => writeln!(out, "warning: {}", record.args()),
        finer => writeln!(out, "{}: {}: {}", finer.as_str().to_lowercase(), record.target(), record.args()),
    }
}
