use super::{FormatPolicy, SafeStateOptions};
use crate::Calibration;
use crate::line::{SerialOptions, Spin};
use pneudrive_protocol::{Baud, Counts, Echo};

/// How to find out whether the adapter returns the host's own bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EchoMode {
    /// Send a request to a board that is not there: only an echo can answer it.
    Detect {
        /// A board number that is not in use.
        unused_board: u8,
    },
    /// It is known.
    Known(Echo),
}

/// Settings of the bus. Times are ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusOptions {
    /// Line rate. 1 Mbaud on the original's boards.
    pub baud: Baud,
    /// How long a board may think before it answers, adapters and the scheduler included. The
    /// original's host waited nominally 2 ms, its board's loop took 0.86 ms.
    pub answer_allowance_ns: u64,
    /// How long after its timeout an answer may still come, and a board that did not answer is left
    /// alone. An answer later than this can be taken for that to the next request. The original's
    /// boards were seen to be 1 ms late at most.
    pub late_answer_limit_ns: u64,
    /// Which packet formats may be used.
    pub frames: FormatPolicy,
    /// Whether to ask boards that check for a session, in which each request is obeyed once. Boards
    /// of before sessions go on without. On by default.
    pub sessions: bool,
    /// Whether the adapter echoes.
    pub echo: EchoMode,
    /// Whether to look for answers without sleeping.
    pub spin: Spin,
    /// When boards of the original kind count as vented at the end.
    pub safe_state: SafeStateOptions,
    /// The count that commands 0 kPa: see [`Calibration::vent`].
    pub vent: Counts,
}

impl BusOptions {
    /// How often 0 kPa is commanded to each board when a run ends.
    pub const SAFE_STATE_REPEATS: usize = 3;
    /// How long the line must be silent to count as idle after a disturbance, beyond the protocol's
    /// idle gap: the time in which bytes on their way through kernel and adapter should have come.
    const IDLE_MARGIN_NS: u64 = 200_000;
    /// What a busy machine may hold the host up for without its answers being refused.
    const OLDEST_MARGIN_NS: u64 = 50_000_000;
    /// A line that is not idle after this many packet times has a babbling board on it.
    const DRAIN_LIMIT_PACKETS: u64 = 100;

    /// With boards whose sensors are calibrated: what vents them, and what they read then.
    #[must_use]
    pub fn calibrated(self, calibration: &Calibration, boards: &[u8]) -> Self {
        let safe_state = SafeStateOptions { vented: calibration.vented(boards), ..self.safe_state };
        Self { safe_state, vent: calibration.vent(boards), ..self }
    }

    /// A board's timeout: request and answer on the wire, and the allowance. What a missing board
    /// costs the others.
    pub const fn answer_timeout_ns(&self) -> u64 {
        self.baud.exchange_ns() + self.answer_allowance_ns
    }

    /// An answer that the host reads later than this after the request is not believed: the host
    /// stood still, and the pressures in it are from before.
    pub const fn oldest_answer_ns(&self) -> u64 {
        self.answer_timeout_ns() + self.late_answer_limit_ns + Self::OLDEST_MARGIN_NS
    }

    /// What an exchange takes at most as long as the host is not held up: bytes that nobody asked
    /// for before it, its timeout, and bytes that are no answer.
    pub const fn longest_exchange_ns(&self) -> u64 {
        self.answer_timeout_ns() + 2 * (self.drain_limit_ns() + self.idle_ns())
    }

    /// Silence that ends a disturbance.
    pub const fn idle_ns(&self) -> u64 {
        self.baud.idle_gap_ns() + Self::IDLE_MARGIN_NS
    }

    /// How long is waited for that silence at most.
    pub const fn drain_limit_ns(&self) -> u64 {
        Self::DRAIN_LIMIT_PACKETS * self.baud.packet_ns()
    }

    pub(super) fn serial(&self) -> SerialOptions {
        SerialOptions { baud: self.baud, spin: self.spin }
    }
}

impl BusOptions {
    /// What boards are allowed before they answer unless something else is asked for, ns.
    pub const ANSWER_ALLOWANCE_NS: u64 = 2_000_000;

    /// How late an answer may be unless something else is asked for, ns.
    pub const LATE_ANSWER_LIMIT_NS: u64 = 10_000_000;

    /// What virtual boards are allowed before they answer, ns: they share the machine's cores with
    /// the host and whatever else runs there, and an answer that is late costs more than an
    /// exchange that waits.
    pub const VIRTUAL_ALLOWANCE_NS: u64 = 20_000_000;
}

impl Default for BusOptions {
    fn default() -> Self {
        Self {
            baud: Baud::ORIGINAL,
            answer_allowance_ns: Self::ANSWER_ALLOWANCE_NS,
            late_answer_limit_ns: Self::LATE_ANSWER_LIMIT_NS,
            frames: FormatPolicy::default(),
            sessions: true,
            echo: EchoMode::Detect { unused_board: u8::MAX },
            spin: Spin::Never,
            safe_state: SafeStateOptions::default(),
            vent: Counts::ATMOSPHERE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timeouts_follow_the_wire() {
        assert_eq!(BusOptions::default().answer_timeout_ns(), 2_200_000);
        let slow = BusOptions { baud: Baud::new(9_600).unwrap(), ..BusOptions::default() };
        // 20 characters of 10 bits at 9600 baud are 20.83 ms.
        assert_eq!(slow.answer_timeout_ns(), 20_833_334 + 2_000_000);
    }
}
