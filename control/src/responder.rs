use crate::{BoardConfig, Micros};
use pneudrive_protocol::{Address, FrameStatistics, Request, RequestDecoder};

/// Listens to the bus: finds the requests to this board, notices gaps, and does not listen to itself.
#[derive(Debug, Clone)]
pub(crate) struct Responder {
    decoder: RequestDecoder,
    /// Distance between the ends of two characters that has an idle gap between them.
    gap: Micros,
    answer_time: Micros,
    last_byte: Option<Micros>,
    deaf_until: Micros,
}

impl Responder {
    pub(crate) fn new(config: &BoardConfig, address: Address) -> Self {
        // From the end of one character to the end of the next: the gap and the character itself. Half a character
        // less, so that a gap of just the right length is seen whatever the resolution of the time stamps.
        let half_character_ns = config.baud.characters_ns(1) / 2;
        let gap_ns = config.baud.idle_gap_ns() + half_character_ns;
        Self {
            decoder: RequestDecoder::new(address),
            gap: Micros::new(gap_ns / 1_000),
            answer_time: Micros::new(config.baud.packet_ns() / 1_000),
            last_byte: None,
            deaf_until: Micros::ZERO,
        }
    }

    /// Takes a byte whose stop bit ended at `now`; gives the request that it completes.
    pub(crate) fn byte(&mut self, now: Micros, byte: u8) -> Option<Request> {
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

    /// An answer leaves the board. It takes a packet's time at least, and until then all that can be heard is
    /// its own echo (which would look like a request to this board).
    pub(crate) fn answered(&mut self, now: Micros) {
        self.deaf_until = now.after(self.answer_time);
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

    pub(crate) fn address(&self) -> Address {
        self.decoder.address()
    }

    pub(crate) fn statistics(&self) -> FrameStatistics {
        self.decoder.statistics()
    }
}
