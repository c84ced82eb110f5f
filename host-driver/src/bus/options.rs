use super::{FormatPolicy, SafeStateOptions};
use crate::Calibration;
use crate::line::{SerialOptions, Spin};
use crate::time::saturating_ns;
use pneudrive_protocol::{Baud, Counts, Echo};
use std::time::Duration;

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

/// Settings of the bus. Begin with the default, and change what differs:
///
/// ```
/// use pneudrive_host::bus::{BusOptions, FormatPolicy};
/// use std::time::Duration;
///
/// let options = BusOptions::default().formats(FormatPolicy::Checked).answer_allowance(Duration::from_millis(5));
/// assert_eq!(options.answer_timeout(), Duration::from_micros(5_200));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct BusOptions {
    /// Line rate. 1 Mbaud on the original's boards.
    pub baud: Baud,
    /// How long a board may think before it answers, adapters and the scheduler included. The
    /// original's host waited nominally 2 ms, its board's loop took 0.86 ms.
    pub answer_allowance: Duration,
    /// How long after its timeout an answer may still come, and a board that did not answer is left
    /// alone. An answer later than this can be taken for that to the next request. The original's
    /// boards were seen to be 1 ms late at most.
    pub late_answer_limit: Duration,
    /// Which packet formats may be used.
    pub formats: FormatPolicy,
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
    /// What boards are allowed before they answer unless something else is asked for.
    pub const ANSWER_ALLOWANCE: Duration = Duration::from_millis(2);
    /// How late an answer may be unless something else is asked for.
    pub const LATE_ANSWER_LIMIT: Duration = Duration::from_millis(10);
    /// What virtual boards are allowed before they answer: they share the machine's cores with the
    /// host and whatever else runs there, and an answer that is late costs more than an exchange
    /// that waits.
    pub const VIRTUAL_ALLOWANCE: Duration = Duration::from_millis(20);

    /// Line rate.
    #[must_use]
    pub fn baud(self, baud: Baud) -> Self {
        Self { baud, ..self }
    }

    /// How long a board may think before it answers.
    #[must_use]
    pub fn answer_allowance(self, answer_allowance: Duration) -> Self {
        Self { answer_allowance, ..self }
    }

    /// How long after its timeout an answer may still come.
    #[must_use]
    pub fn late_answer_limit(self, late_answer_limit: Duration) -> Self {
        Self { late_answer_limit, ..self }
    }

    /// Which packet formats may be used.
    #[must_use]
    pub fn formats(self, formats: FormatPolicy) -> Self {
        Self { formats, ..self }
    }

    /// Whether to ask boards that check for a session.
    #[must_use]
    pub fn sessions(self, sessions: bool) -> Self {
        Self { sessions, ..self }
    }

    /// Whether the adapter echoes.
    #[must_use]
    pub fn echo(self, echo: EchoMode) -> Self {
        Self { echo, ..self }
    }

    /// Whether to look for answers without sleeping.
    #[must_use]
    pub fn spin(self, spin: Spin) -> Self {
        Self { spin, ..self }
    }

    /// With boards whose sensors are calibrated: what vents them, and what they read then.
    #[must_use]
    pub fn calibrated(self, calibration: &Calibration, boards: &[u8]) -> Self {
        let safe_state = SafeStateOptions { vented: calibration.vented(boards), ..self.safe_state };
        Self { safe_state, vent: calibration.vent(boards), ..self }
    }

    /// A board's timeout: request and answer on the wire, and the allowance. What a missing board
    /// costs the others.
    pub fn answer_timeout(&self) -> Duration {
        Duration::from_nanos(self.times().answer_timeout_ns())
    }

    /// Its times as they are compared with the line's clock.
    pub(crate) fn times(&self) -> BusTimes {
        BusTimes {
            baud: self.baud,
            answer_allowance_ns: saturating_ns(self.answer_allowance),
            late_answer_limit_ns: saturating_ns(self.late_answer_limit),
        }
    }

    pub(super) fn serial(&self) -> SerialOptions {
        SerialOptions::default().baud(self.baud).spin(self.spin)
    }
}

/// The times of [`BusOptions`] at the line rate in effect, ns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BusTimes {
    pub(super) baud: Baud,
    answer_allowance_ns: u64,
    pub(super) late_answer_limit_ns: u64,
}

impl BusTimes {
    /// How long the line must be silent to count as idle after a disturbance, beyond the protocol's
    /// idle gap: the time in which bytes on their way through kernel and adapter should have come.
    const IDLE_MARGIN_NS: u64 = 200_000;
    /// What a busy machine may hold the host up for without its answers being refused.
    const OLDEST_MARGIN_NS: u64 = 50_000_000;
    /// A line that is not idle after this many packet times has a babbling board on it.
    const DRAIN_LIMIT_PACKETS: u64 = 100;

    /// [`BusOptions::answer_timeout`].
    pub(crate) const fn answer_timeout_ns(&self) -> u64 {
        self.baud.exchange_ns() + self.answer_allowance_ns
    }

    /// An answer that the host reads later than this after the request is not believed: the host
    /// stood still, and the pressures in it are from before.
    pub(super) const fn oldest_answer_ns(&self) -> u64 {
        self.answer_timeout_ns() + self.late_answer_limit_ns + Self::OLDEST_MARGIN_NS
    }

    /// What an exchange takes at most as long as the host is not held up: bytes that nobody asked
    /// for before it, its timeout, and bytes that are no answer.
    pub(crate) const fn longest_exchange_ns(&self) -> u64 {
        self.answer_timeout_ns() + 2 * (self.drain_limit_ns() + self.idle_ns())
    }

    /// Silence that ends a disturbance.
    pub(super) const fn idle_ns(&self) -> u64 {
        self.baud.idle_gap_ns() + Self::IDLE_MARGIN_NS
    }

    /// How long is waited for that silence at most.
    pub(super) const fn drain_limit_ns(&self) -> u64 {
        Self::DRAIN_LIMIT_PACKETS * self.baud.packet_ns()
    }
}

impl Default for BusOptions {
    fn default() -> Self {
        Self {
            baud: Baud::ORIGINAL,
            answer_allowance: Self::ANSWER_ALLOWANCE,
            late_answer_limit: Self::LATE_ANSWER_LIMIT,
            formats: FormatPolicy::default(),
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
        assert_eq!(BusOptions::default().answer_timeout(), Duration::from_micros(2_200));
        let slow = BusOptions::default().baud(Baud::new(9_600).unwrap());
        // 20 characters of 10 bits at 9600 baud are 20.83 ms.
        assert_eq!(slow.answer_timeout(), Duration::from_nanos(20_833_334 + 2_000_000));
    }
}
