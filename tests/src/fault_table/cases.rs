//! Which faults, how often.

/// A fault of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// As `pneudrive-sim --fault` takes it.
    pub fault: &'static str,
    /// How long it lasts, ms: what follows it is the recovery. 0 for faults of single characters.
    pub lasts_ms: u64,
    /// How long a run on emulated chips lasts, s of virtual time.
    pub chip_seconds: u64,
}

/// A fault that strikes many times a second: a few seconds are enough on emulated chips, which take
/// their time.
const fn case(fault: &'static str, lasts_ms: u64) -> Case {
    Case { fault, lasts_ms, chip_seconds: 3 }
}

/// A fault that strikes every few seconds.
const fn rare(fault: &'static str, lasts_ms: u64) -> Case {
    Case { fault, lasts_ms, chip_seconds: 20 }
}

/// Every kind of fault, at rates from what a usable bus shows to what none survives for long.
pub fn cases() -> &'static [Case] {
    const CASES: &[Case] = &[
        case("bit_flip=1e-4", 0),
        case("bit_flip=1e-3", 0),
        case("bit_flip=1e-2", 0),
        case("drop=1e-4", 0),
        case("drop=1e-3", 0),
        case("drop=1e-2", 0),
        case("duplicate=1e-4", 0),
        case("duplicate=1e-3", 0),
        case("duplicate=1e-2", 0),
        case("delay=1e-4,ms=3.2", 3),
        case("delay=1e-3,ms=3.2", 3),
        case("delay=1e-4,ms=30", 30),
        case("echo=0.01", 0),
        case("echo=1", 0),
        case("stray=10", 0),
        case("stray=1000", 0),
        case("noise=2,ms=1", 1),
        case("noise=50,ms=1", 1),
        rare("unplug=0.2,ms=1000", 1_000),
        case("unplug=2,ms=100", 100),
        rare("babble=0.2,ms=50", 50),
        case("babble=2,ms=50", 50),
        rare("power_cycle=0.1,ms=500", 500),
        rare("power_cycle=0.5,ms=10", 10),
    ];
    CASES
}
