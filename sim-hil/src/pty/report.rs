use crate::bus::BusCounters;
use serde::{Deserialize, Serialize};

/// How well virtual time kept to the wall clock.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PaceReport {
    /// Virtual time simulated, s.
    pub virtual_s: f64,
    /// Virtual time that stood still because the simulator could not keep up, ms.
    pub slipped_ms: f64,
    /// What requests were dated back by, us.
    pub pty_round_trip_us: f64,
    /// Runs of bytes handed to the client.
    pub handed_over: u64,
    /// Mean delay of their last byte behind its stop bit, us; before the pty's own latency.
    pub late_mean_us: f64,
    /// Largest delay, us.
    pub late_max_us: f64,
    /// Bytes lost because the client did not read.
    pub overrun_bytes: u64,
    /// Times that a client closed the port.
    pub clients_gone: u64,
}

/// What the simulator prints at its end: the bus's counters, and the pace beside them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SimReport {
    /// What happened on the bus.
    #[serde(flatten)]
    pub bus: BusCounters,
    /// How well time was kept.
    pub pace: PaceReport,
}
