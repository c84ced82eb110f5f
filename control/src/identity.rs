//! What a board is, which does not change while it runs.

use pneudrive_protocol::pages::{About, ChipKind, PostMortem};

/// What a board knows of itself beside its control loop, for those who ask for its pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// What it runs on, and in which version.
    pub about: About,
    /// Resets by the watchdog since power-on.
    pub watchdog_resets: u32,
    /// What the numbers of its sessions are made from beside its clock: other than in the run
    /// before, so that they do not come again.
    pub session_seed: u32,
    /// The words of the run before this one, all 0 if nothing is known of it.
    pub post_mortem: [u32; PostMortem::WORDS],
}

impl Identity {
    /// A board of this version on `chip`, after power-on.
    pub const fn of_chip(chip: ChipKind) -> Self {
        Self {
            about: About { chip, version: VERSION },
            watchdog_resets: 0,
            session_seed: 0,
            post_mortem: [0; PostMortem::WORDS],
        }
    }
}

/// That of all crates.
const VERSION: [u16; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn number(digits: &str) -> u16 {
    match u16::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => panic!("cargo gives version numbers in digits"),
    }
}
