//! What the original client reached: PneuDrive, C. C. Johnson, D. G. Cheney, D. L. Cordon, M. D.
//! Killpack (arXiv:2504.00222, 2025).

use serde::Serialize;

/// Its loop rates for 1, 2, .. boards at 1 Mbaud.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OriginalClient {
    /// Mean rates of its unmodified source against a plain responder on a pty, Hz: medians of three
    /// rounds, on two shared x86-64 cores of which it took one.
    pub plain_responder_hz: [f64; 4],
    /// Its share of a core there.
    pub cpu_share: f64,
    /// Mean rates that its authors published for their hardware, Hz; the boards' own loop of 0.86
    /// ms set the pace there.
    pub published_hz: [f64; 3],
    /// Where the figures are from.
    pub source: &'static str,
}

/// The figures.
pub const ORIGINAL_CLIENT: OriginalClient = OriginalClient {
    plain_responder_hz: [4021.0, 2097.0, 1365.0, 1061.0],
    cpu_share: 0.95,
    published_hz: [1164.3, 980.9, 749.5],
    source: "original client: byu-rad-lab/pneudrive cf79439, against a responder that answers when the wire would have delivered, on two shared \
             x86-64 cores; published: arXiv:2504.00222",
};
