//! The one place that reads the clocks: dates for files, seconds for timings.

use std::path::Path;
use std::sync::LazyLock;
use std::time::{Instant, SystemTime};

use pneudrive_model::data::Source;
use pneudrive_model::experiment::Origin;
use pneudrive_model::store::{Provenance, RigSource};

/// Program, date and command line of this run.
pub fn origin() -> Origin {
    Origin {
        program: concat!("pneudrive-model ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        command: command_line(),
    }
}

/// Where the parameters of this run come from.
pub fn provenance(data: &Source, rig: Option<&Path>) -> Provenance {
    let Origin { program, created, command } = origin();
    let rig = rig.map(|path| RigSource { file: path.display().to_string() });
    Provenance { program, created, command, data: data.clone(), rig }
}

/// Seconds of a steady clock since the first call.
pub fn seconds() -> f64 {
    static BEGAN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGAN.elapsed().as_secs_f64()
}

/// The command line, arguments with spaces or other special characters quoted for a shell.
fn command_line() -> String {
    let mut words = vec!["pneudrive-model".to_owned()];
    words.extend(super::arguments().iter().map(|word| quoted(&word.to_string_lossy())));
    words.join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_when_a_shell_would_split_them() {
        assert_eq!(quoted("--fit-seconds=15"), "--fit-seconds=15");
        assert_eq!(quoted("b0_p0_kpa=P (psi):psi"), "'b0_p0_kpa=P (psi):psi'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
