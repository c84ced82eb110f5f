//! Which faults, how often.

/// A fault of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// As `pneudrive-sim --fault` takes it.
    pub fault: &'static str,
    /// How long it lasts, ms: what follows it is the recovery. 0 for faults of single characters.
    pub lasts_ms: u64,
    /// Whether the table has it on emulated chips too: one rate of every kind, because they take their time.
    pub on_chips: bool,
}

const fn case(fault: &'static str, lasts_ms: u64) -> Case {
    Case { fault, lasts_ms, on_chips: false }
}

const fn on_chips_too(fault: &'static str, lasts_ms: u64) -> Case {
    Case { fault, lasts_ms, on_chips: true }
}

/// Every kind of fault, at rates from what a usable bus shows to what none survives for long.
pub fn cases() -> &'static [Case] {
    const CASES: &[Case] = &[
        case("bit_flip=1e-4", 0),
        on_chips_too("bit_flip=1e-3", 0),
        case("bit_flip=1e-2", 0),
        case("drop=1e-4", 0),
        on_chips_too("drop=1e-3", 0),
        case("drop=1e-2", 0),
        case("duplicate=1e-4", 0),
        on_chips_too("duplicate=1e-3", 0),
        case("duplicate=1e-2", 0),
        case("delay=1e-4,ms=3.2", 3),
        on_chips_too("delay=1e-3,ms=3.2", 3),
        case("delay=1e-4,ms=30", 30),
        on_chips_too("echo=0.01", 0),
        case("echo=1", 0),
        case("stray=10", 0),
        on_chips_too("stray=1000", 0),
        case("noise=2,ms=1", 1),
        on_chips_too("noise=50,ms=1", 1),
        case("unplug=0.2,ms=1000", 1_000),
        on_chips_too("unplug=2,ms=100", 100),
        case("babble=0.2,ms=50", 50),
        on_chips_too("babble=2,ms=50", 50),
        case("power_cycle=0.1,ms=500", 500),
        on_chips_too("power_cycle=0.5,ms=10", 10),
    ];
    CASES
}
