use super::ExchangeError;
use super::delays::{Delays, Window};
use super::format::FormatNegotiation;
use super::session::HostSession;
use super::usual_delay::UsualDelay;
use pneudrive_protocol::{CHANNELS, Counts, PacketFormat};

/// What has happened between the host and one board. Every request is in `asked`, and in exactly
/// one of the seven below it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Requests sent (or meant to be, where the line was busy).
    pub asked: u64,
    /// Valid answers in time.
    pub answered: u64,
    /// Nothing came.
    pub silent: u64,
    /// No packet came, but bytes.
    pub garbled: u64,
    /// The echo was damaged or incomplete.
    pub echo: u64,
    /// Only another board answered.
    pub other_board: u64,
    /// Only an answer to an earlier request, or one in the other format, came from it; its answer
    /// was read too late; or it is in a session with another host.
    pub stale: u64,
    /// The line was busy or failed.
    pub line: u64,
    /// Packets from this board that came when it was not its turn: late answers. Not requests, so
    /// beside the others.
    pub late: u64,
    /// Page requests. They are not in `asked`.
    pub pages_asked: u64,
    /// Answers to them in time, also that there is no such entry.
    pub pages_answered: u64,
}

impl Counters {
    /// Requests without a valid answer in time.
    pub fn lost(&self) -> u64 {
        self.asked - self.answered
    }

    /// Answers that came and were not accepted: damaged, or late. One that came while another board
    /// was asked counts with the board that sent it.
    pub fn rejected(&self) -> u64 {
        self.garbled + self.echo + self.late
    }
}

/// What the host remembers of a board.
#[derive(Debug, Clone)]
pub(super) struct Peer {
    pub(super) negotiation: FormatNegotiation,
    pub(super) session: HostSession,
    pub(super) usual_delay: UsualDelay,
    counters: Counters,
    /// Last request that may still be answered, ns.
    owes_since_ns: Option<u64>,
    quiet_until_ns: u64,
    /// How long after its timeout an answer may still come: the configured limit, or more for a
    /// board that was later.
    late_limit_ns: u64,
    usual_late_limit_ns: u64,
    /// How late its answers really are.
    delays: Delays,
    /// Until then an answer may be that to an earlier request, ns.
    doubtful_until_ns: u64,
    /// Requests in a row that failed and were followed by another one sooner than the limit allows.
    early: u32,
    /// Prompt answers since the last failure.
    prompt: u32,
    /// It has been sent a command of more than 0 kPa, whether or not it obeyed.
    pressurised: bool,
    /// An answer of it was accepted, of whatever kind.
    seen: bool,
}

impl Peer {
    /// A board that keeps answering later than any limit could not be used anyway.
    const LATEST_NS: u64 = 200_000_000;
    /// After so many prompt answers in a row a delay is history.
    const FORGIVEN_AFTER: u32 = 100;
    /// After so many failures in a row the whole limit is waited for: by then more is wrong than a
    /// lost packet.
    const EARLY_TRIES: u32 = 3;

    pub(super) fn new(late_limit_ns: u64, negotiation: FormatNegotiation, sessions: bool) -> Self {
        Self {
            negotiation,
            session: HostSession::new(sessions),
            usual_delay: UsualDelay::default(),
            counters: Counters::default(),
            owes_since_ns: None,
            quiet_until_ns: 0,
            late_limit_ns,
            usual_late_limit_ns: late_limit_ns,
            delays: Delays::default(),
            doubtful_until_ns: 0,
            early: 0,
            prompt: 0,
            pressurised: false,
            seen: false,
        }
    }

    /// Forgets everything but the counters, that it is there, and that it may hold a set point.
    pub(super) fn renew(&mut self, negotiation: FormatNegotiation, sessions: bool) {
        *self = Self {
            counters: self.counters,
            pressurised: self.pressurised,
            seen: self.seen,
            ..Self::new(self.usual_late_limit_ns, negotiation, sessions)
        };
    }

    pub(super) fn counters(&self) -> Counters {
        self.counters
    }

    /// Notes what is about to be commanded.
    pub(super) fn note_command(&mut self, commands: &[Counts; CHANNELS]) {
        self.pressurised |= commands.iter().any(|&command| command > Counts::ATMOSPHERE);
    }

    /// Whether it has ever been commanded more than 0 kPa.
    pub(super) fn was_pressurised(&self) -> bool {
        self.pressurised
    }

    /// An answer of it was accepted.
    pub(super) fn note_presence(&mut self) {
        self.seen = true;
    }

    /// Whether an answer of it was ever accepted.
    pub(super) fn was_seen(&self) -> bool {
        self.seen
    }

    /// Until when the board is to be left alone, ns.
    pub(super) fn quiet_until_ns(&self) -> u64 {
        self.quiet_until_ns
    }

    /// It was asked for an entry of a page, and has answered or not.
    pub(super) fn asked_for_page(&mut self, answered: bool) {
        self.counters.pages_asked += 1;
        self.counters.pages_answered += u64::from(answered);
        self.seen |= answered;
    }

    /// It answered a request in `format`, so long after it.
    pub(super) fn answered(&mut self, format: PacketFormat, delay_ns: u64) {
        self.negotiation.answered(format);
        if let PacketFormat::Sealed(seal) = format {
            self.session.was_answered(seal.number());
        }
        self.delays.seen(delay_ns);
        self.usual_delay.seen(delay_ns);
        self.early = 0;
        self.counters.asked += 1;
        self.counters.answered += 1;
        self.seen = true;
        self.owes_since_ns = None;
        self.prompt = self.prompt.saturating_add(1);
        if self.prompt >= Self::FORGIVEN_AFTER {
            self.late_limit_ns = self.usual_late_limit_ns;
        }
    }

    /// An exchange failed. `owed_since_ns` is when the request was sent, if it may still be
    /// answered; `timeout_ns` is how long an answer is waited for.
    pub(super) fn failed(&mut self, error: &ExchangeError, owed_since_ns: Option<u64>, timeout_ns: u64) {
        self.counters.asked += 1;
        let counter = match error {
            ExchangeError::NoAnswer { .. } => &mut self.counters.silent,
            ExchangeError::Garbled { .. } => &mut self.counters.garbled,
            ExchangeError::EchoDamaged { .. } | ExchangeError::EchoMissing { .. } => &mut self.counters.echo,
            ExchangeError::OtherBoard { .. } => &mut self.counters.other_board,
            ExchangeError::Stale { .. }
            | ExchangeError::OriginalFormat { .. }
            | ExchangeError::InSession { .. }
            | ExchangeError::TooOld { .. } => &mut self.counters.stale,
            ExchangeError::LineBusy { .. } | ExchangeError::Line(_) => &mut self.counters.line,
        };
        *counter += 1;
        match error {
            ExchangeError::OriginalFormat { .. } => self.negotiation.answered(PacketFormat::Unchecked),
            _ => self.negotiation.failed(),
        }
        self.session.failed();
        self.prompt = 0;
        self.owes_since_ns = owed_since_ns;
        if let Some(since) = owed_since_ns {
            let limit_ns = since + timeout_ns + self.late_limit_ns;
            self.quiet_until_ns = match self.delays.window() {
                Some(window) if self.early < Self::EARLY_TRIES => {
                    self.early += 1;
                    self.doubtful_until_ns = self.doubtful_until_ns.max(limit_ns);
                    limit_ns.min(since + timeout_ns.max(window.to_ns))
                }
                _ => limit_ns,
            };
        }
    }

    /// If at `now_ns` an answer may be that to an earlier request: when the answer to a request
    /// sent now can come.
    pub(super) fn doubt(&self, now_ns: u64) -> Option<Window> {
        self.delays.window().filter(|_| now_ns < self.doubtful_until_ns)
    }

    /// A packet of this board came when it was not its turn.
    ///
    /// If it took more than half the time that such packets are waited for, the next one may take
    /// longer still: the limit becomes twice the delay. The board stays quiet for the whole time,
    /// because it may owe more than one answer.
    pub(super) fn heard_late(&mut self, now_ns: u64) {
        self.counters.late += 1;
        let Some(since) = self.owes_since_ns else { return };
        let delay = now_ns.saturating_sub(since);
        self.delays.seen_late(delay.min(Self::LATEST_NS));
        if 2 * delay > self.quiet_until_ns.saturating_sub(since) {
            self.late_limit_ns = self.late_limit_ns.max((2 * delay).min(Self::LATEST_NS));
            self.quiet_until_ns = self.quiet_until_ns.max(since + self.late_limit_ns);
        }
    }
}

impl std::ops::Sub for Counters {
    type Output = Self;

    /// What has happened since `before`.
    fn sub(self, before: Self) -> Self {
        Self {
            asked: self.asked - before.asked,
            answered: self.answered - before.answered,
            silent: self.silent - before.silent,
            garbled: self.garbled - before.garbled,
            echo: self.echo - before.echo,
            other_board: self.other_board - before.other_board,
            stale: self.stale - before.stale,
            line: self.line - before.line,
            late: self.late - before.late,
            pages_asked: self.pages_asked - before.pages_asked,
            pages_answered: self.pages_answered - before.pages_answered,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::FormatPolicy;
    use pneudrive_protocol::Address;
    use std::time::Duration;

    const TIMEOUT: u64 = 2_200_000;
    const LIMIT: u64 = 10_000_000;

    fn silent() -> ExchangeError {
        ExchangeError::NoAnswer { asked: Address::of_board(0), waited: Duration::from_micros(2_200) }
    }

    #[test]
    fn a_silent_board_is_left_alone_for_the_limit() {
        let mut peer = Peer::new(LIMIT, FormatNegotiation::new(FormatPolicy::Unchecked), false);
        peer.failed(&silent(), Some(1_000), TIMEOUT);
        assert_eq!(peer.quiet_until_ns(), 1_000 + TIMEOUT + LIMIT);
        peer.heard_late(3_200_000);
        assert_eq!(peer.quiet_until_ns(), 1_000 + TIMEOUT + LIMIT, "3.2 ms is well inside the limit");
    }

    #[test]
    fn the_limit_follows_a_board_that_is_later_than_expected() {
        let mut peer = Peer::new(LIMIT, FormatNegotiation::new(FormatPolicy::Unchecked), false);
        peer.failed(&silent(), Some(0), TIMEOUT);
        peer.heard_late(11_000_000);
        assert_eq!(peer.quiet_until_ns(), 22_000_000);
        peer.failed(&silent(), Some(50_000_000), TIMEOUT);
        assert_eq!(peer.quiet_until_ns(), 50_000_000 + TIMEOUT + 22_000_000);
        (0..100).for_each(|_| peer.answered(PacketFormat::Unchecked, 300_000));
        peer.failed(&silent(), Some(200_000_000), TIMEOUT);
        assert_eq!(peer.quiet_until_ns(), 200_000_000 + TIMEOUT + LIMIT, "forgiven after 100 prompt answers");
    }

    /// Learnt: it is asked again after its timeout, three times; then it is left alone for the
    /// limit as before.
    #[test]
    fn a_board_whose_delays_are_known_is_asked_again_soon() {
        let mut peer = Peer::new(LIMIT, FormatNegotiation::new(FormatPolicy::Unchecked), false);
        (0..500).for_each(|_| peer.answered(PacketFormat::Unchecked, 1_060_000));
        let mut since_ns = 0;
        for _ in 0..3 {
            assert_eq!(peer.doubt(since_ns).is_some(), since_ns > 0);
            peer.failed(&silent(), Some(since_ns), TIMEOUT);
            assert_eq!(peer.quiet_until_ns(), since_ns + TIMEOUT);
            since_ns = peer.quiet_until_ns();
        }
        peer.failed(&silent(), Some(since_ns), TIMEOUT);
        assert_eq!(peer.quiet_until_ns(), since_ns + TIMEOUT + LIMIT);
        assert_eq!(peer.doubt(peer.quiet_until_ns()), None);
    }

    #[test]
    fn every_request_is_counted_once() {
        let mut peer = Peer::new(LIMIT, FormatNegotiation::new(FormatPolicy::Unchecked), false);
        peer.answered(PacketFormat::Unchecked, 300_000);
        peer.failed(&silent(), Some(0), TIMEOUT);
        peer.heard_late(3_000_000);
        let counters = peer.counters();
        assert_eq!((counters.asked, counters.answered, counters.lost(), counters.rejected()), (2, 1, 1, 1));
    }
}
