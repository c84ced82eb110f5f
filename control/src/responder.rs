use crate::{BoardConfig, Micros};
use pneudrive_protocol::{Address, Asked, Baud, FrameStatistics, RequestDecoder};

/// Listens to the bus: finds the requests to this board, notices gaps, and does not listen to
/// itself.
#[derive(Debug, Clone)]
pub(crate) struct Responder {
    decoder: RequestDecoder,
    /// Distance between the ends of two characters that has an idle gap between them.
    gap: Micros,
    /// From a request's end to the moment from which on a byte cannot be an echo.
    deaf_time: Micros,
    /// Answers are so fast that only their end tells when to listen again.
    waits_for_end: bool,
    answer_delay: Micros,
    hears_itself: bool,
    last_byte: Option<Micros>,
    deaf_until: Micros,
}

impl Responder {
    /// An answer begins at most so long after its delay, ns. At 1 Mbaud that is half a character.
    const LATEST_NS: u64 = 5_000;

    pub(crate) fn new(config: &BoardConfig, address: Address) -> Self {
        let mut responder = Self {
            decoder: RequestDecoder::new(address),
            gap: Micros::ZERO,
            deaf_time: Micros::ZERO,
            waits_for_end: false,
            answer_delay: config.answer_delay,
            hears_itself: config.hears_itself,
            last_byte: None,
            deaf_until: Micros::ZERO,
        };
        responder.set_baud(config.baud);
        responder
    }

    /// The line rate is this from now on. What was heard of a packet before is no part of one.
    ///
    /// Once, because start-up copies all code to RAM before a board can answer.
    #[inline(never)]
    pub(crate) fn set_baud(&mut self, baud: Baud) {
        // From the end of one character to the end of the next: the gap and the character itself.
        // Half a character less, so that a gap of just the right length is seen whatever the
        // resolution of the time stamps.
        let half_character_ns = baud.characters_ns(1) / 2;
        self.gap = Micros::new((baud.idle_gap_ns() + half_character_ns) / 1_000);
        let late_ns = half_character_ns.max(Self::LATEST_NS);
        self.waits_for_end = late_ns > half_character_ns;
        let answer_time = Micros::new((baud.packet_ns() + late_ns) / 1_000);
        self.deaf_time = if self.hears_itself { self.answer_delay.after(answer_time) } else { Micros::ZERO };
        self.decoder.line_idle();
    }

    /// Takes a byte whose stop bit ended at `now`; gives the request that it completes.
    pub(crate) fn byte(&mut self, now: Micros, byte: u8) -> Option<Asked> {
        let since_last = self.last_byte.map(|last| now.since(last));
        self.last_byte = Some(now);
        if now < self.deaf_until {
            return None;
        }
        if since_last.is_some_and(|time| time >= self.gap) {
            self.decoder.line_idle();
        }
        self.decoder.push(byte)
    }

    /// An answer leaves the board, and until it has gone all that can be heard is its own echo
    /// (which looks like a request to this board). The next request's first byte ends a whole
    /// character later; half of it is allowed for an answer that begins late.
    ///
    /// Above 1 Mbaud a late answer's echo ends when the next request can have begun, so that
    /// whoever sends it tells [its end](Self::answer_sent).
    pub(crate) fn answered(&mut self, now: Micros) {
        self.deaf_until = now.after(self.deaf_time);
    }

    /// The answer's last stop bit had been sent at `now`: what is stamped later is no echo.
    pub(crate) fn answer_sent(&mut self, now: Micros) {
        if self.waits_for_end {
            self.deaf_until = self.deaf_until.min(now.after(Micros::new(1)));
        }
    }

    pub(crate) fn idle(&mut self) {
        self.decoder.line_idle();
    }

    pub(crate) fn error(&mut self, now: Micros) {
        self.last_byte = Some(now);
        self.decoder.line_error();
    }

    /// The host has fallen silent: the next one may be of the other kind.
    pub(crate) fn forget_host(&mut self) {
        self.decoder.forget_host();
    }

    /// Gives a session to whoever asked for one; false if a host is in one.
    pub(crate) fn offer_session(&mut self, number: u32) -> bool {
        self.decoder.offer(number)
    }

    pub(crate) fn damaged_requests(&self) -> u32 {
        self.decoder.damaged_requests()
    }

    pub(crate) fn address(&self) -> Address {
        self.decoder.address()
    }

    pub(crate) fn statistics(&self) -> FrameStatistics {
        self.decoder.statistics()
    }
}
