use crate::{BoardConfig, Micros};
use pneudrive_protocol::{Address, Asked, FrameStatistics, RequestDecoder};

/// Listens to the bus: finds the requests to this board, notices gaps, and does not listen to itself.
#[derive(Debug, Clone)]
pub(crate) struct Responder {
    decoder: RequestDecoder,
    /// Distance between the ends of two characters that has an idle gap between them.
    gap: Micros,
    /// From a request's end to the moment from which on a byte cannot be an echo.
    deaf_time: Micros,
    last_byte: Option<Micros>,
    deaf_until: Micros,
}

impl Responder {
    pub(crate) fn new(config: &BoardConfig, address: Address) -> Self {
        // From the end of one character to the end of the next: the gap and the character itself. Half a character
        // less, so that a gap of just the right length is seen whatever the resolution of the time stamps.
        let half_character_ns = config.baud.characters_ns(1) / 2;
        let gap_ns = config.baud.idle_gap_ns() + half_character_ns;
        let answer_time = Micros::new((config.baud.packet_ns() + half_character_ns) / 1_000);
        let deaf_time =
            if config.hears_itself { config.answer_delay.after(answer_time) } else { Micros::ZERO };
        Self {
            decoder: RequestDecoder::new(address),
            gap: Micros::new(gap_ns / 1_000),
            deaf_time,
            last_byte: None,
            deaf_until: Micros::ZERO,
        }
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

    /// An answer leaves the board, and until it has gone all that can be heard is its own echo (which looks like a
    /// request to this board). The next request's first byte ends a whole character later; half of it is allowed for
    /// an answer that begins late.
    pub(crate) fn answered(&mut self, now: Micros) {
        self.deaf_until = now.after(self.deaf_time);
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
