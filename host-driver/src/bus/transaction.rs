//! The steps of an exchange on the line.

use super::delays::Window;
use super::guard::with_guard;
use super::{Answer, BoardFormat, Bus, ExchangeError, HeardBytes};
use crate::line::{Line, LineError};
use pneudrive_protocol::{
    Address, AnswerDecoder, CHANNELS, CheckedPacket, Counts, Echo, FrameFinder, Heard, PACKET_LEN, Packet,
    PacketFormat, PageRequest, Session,
};
use std::time::Duration;

/// Bytes looked at in one go: a whole echo and answer, what noise may add, and all answers that an
/// adapter may have held back. Of those the last one counts, so they must be seen together.
const BUFFER: usize = 512;

/// Bytes that come back for a request.
pub(super) fn expected_bytes(echo: Echo) -> usize {
    match echo {
        Echo::Absent => PACKET_LEN,
        Echo::Present => 2 * PACKET_LEN,
    }
}

/// What a board is asked.
#[derive(Debug, Clone, Copy)]
pub(super) enum Question {
    /// Its pressures, for new commands.
    Pressures(Packet, PacketFormat),
    /// An entry of a page, whose words come in place of the pressures.
    Page(PageRequest),
}

impl Question {
    fn address(&self) -> Address {
        match self {
            Self::Pressures(request, _) => request.address,
            Self::Page(request) => request.address,
        }
    }

    /// Whether its answer does not say which request it belongs to.
    fn is_unchecked(&self) -> bool {
        matches!(self, Self::Pressures(_, PacketFormat::Unchecked))
    }
}

impl<L: Line> Bus<L> {
    /// Asks, and listens until the answer is complete or the time is up.
    pub(super) fn transact(&mut self, question: Question) -> Result<Answer, ExchangeError> {
        let guard_echo_due = self.prepare()?;
        let asked = question.address();
        let session = self.peers[usize::from(asked.board())].session.current();
        let (bytes, mut receiver) =
            AnswerReceiver::for_question(question, session, self.echo, guard_echo_due);
        let sent_ns = self.line.now_ns();
        let doubt = self.peers[usize::from(asked.board())].doubt(sent_ns);
        self.line.send(&bytes)?;
        self.last_byte = bytes.last().copied();
        if let Some(delay_ns) = self.peers[usize::from(asked.board())].usual_delay.ns() {
            self.line.expect_answer_at(sent_ns + delay_ns);
        }
        let deadline = sent_ns + self.times.answer_timeout_ns();
        let mut wanted = expected_bytes(self.echo);
        loop {
            let mut bytes = [0; BUFFER];
            let count = self.line.receive(&mut bytes, wanted, deadline)?;
            let now_ns = self.line.now_ns();
            self.last_byte = bytes[..count].last().copied().or(self.last_byte);
            for &byte in &bytes[..count] {
                if let Some(packet) = receiver.push(byte) {
                    self.peers[usize::from(packet.address.board())].heard_late(now_ns);
                }
            }
            if let Some(pressures) = receiver.accepted_answer() {
                if now_ns - sent_ns > self.times.oldest_answer_ns() {
                    return Err(ExchangeError::TooOld { asked, waited: waited(sent_ns, now_ns) });
                }
                if let Some(window) = doubt.filter(|_| question.is_unchecked()) {
                    return self.answer_in_doubt(receiver, window, sent_ns, now_ns);
                }
                self.emptied_ns = (count < BUFFER).then_some(now_ns);
                return Ok(Answer { pressures, sent_ns, answered_ns: now_ns });
            }
            if receiver.decoder.answered_unchecked() && self.format(asked.board()) == BoardFormat::Unknown {
                return Err(ExchangeError::OriginalFormat { asked, waited: waited(sent_ns, now_ns) });
            }
            if now_ns >= deadline {
                return Err(receiver.failure(waited(sent_ns, now_ns)));
            }
            wanted = 1;
        }
    }

    /// An answer came at `answered_ns`, but an earlier request to the same board may still be
    /// answered. Listens for as long as the answer to this one may need to follow that to the
    /// earlier one. The last answer is believed, if it came when this board's answers come.
    fn answer_in_doubt(
        &mut self,
        mut receiver: AnswerReceiver,
        window: Window,
        sent_ns: u64,
        mut answered_ns: u64,
    ) -> Result<Answer, ExchangeError> {
        let asked = receiver.asked;
        let limit_ns = sent_ns + self.times.drain_limit_ns();
        loop {
            let until_ns = (answered_ns + window.to_ns).min(limit_ns);
            let mut bytes = [0; BUFFER];
            let count = self.line.receive(&mut bytes, 1, until_ns)?;
            let now_ns = self.line.now_ns();
            self.last_byte = bytes[..count].last().copied().or(self.last_byte);
            for &byte in &bytes[..count] {
                let Some(packet) = receiver.push(byte) else { continue };
                self.peers[usize::from(packet.address.board())].heard_late(now_ns);
                if packet.address == asked {
                    answered_ns = now_ns;
                }
            }
            if now_ns >= until_ns {
                break;
            }
        }
        match receiver.accepted_answer() {
            Some(pressures) if window.contains(answered_ns - sent_ns) => {
                Ok(Answer { pressures, sent_ns, answered_ns })
            }
            _ => Err(ExchangeError::Stale { asked, waited: waited(sent_ns, self.line.now_ns()) }),
        }
    }

    /// Discards what came while nobody had been asked.
    ///
    /// Right after an answer there is nothing to look for: since the line was read empty, no
    /// character has had the time to come.
    pub(super) fn expect_silence(&mut self) -> Result<(), ExchangeError> {
        let character_ns = self.times.baud.characters_ns(1);
        let emptied_ns = self.emptied_ns.take();
        if emptied_ns.is_some_and(|then| self.line.now_ns() - then < character_ns) {
            return Ok(());
        }
        let mut bytes = [0; BUFFER];
        let count = self.line.receive(&mut bytes, 0, 0)?;
        if count == 0 {
            return Ok(());
        }
        let mut unsolicited = UnsolicitedReceiver::new();
        self.discard(&mut unsolicited, &bytes[..count]);
        self.drain_into(&mut unsolicited)
    }

    /// Listens, and discards, until the line has been idle.
    pub(super) fn drain(&mut self) -> Result<(), ExchangeError> {
        self.drain_into(&mut UnsolicitedReceiver::new())
    }

    fn drain_into(&mut self, unsolicited: &mut UnsolicitedReceiver) -> Result<(), ExchangeError> {
        let started_ns = self.line.now_ns();
        let limit_ns = started_ns + self.times.drain_limit_ns();
        loop {
            let mut bytes = [0; BUFFER];
            let now_ns = self.line.now_ns();
            if now_ns >= limit_ns {
                let waited = waited(started_ns, now_ns);
                return Err(ExchangeError::LineBusy { heard: unsolicited.heard, waited });
            }
            match self.line.receive(&mut bytes, 1, now_ns + self.times.idle_ns())? {
                0 => return Ok(()),
                count => self.discard(unsolicited, &bytes[..count]),
            }
        }
    }

    /// Listens until `board`'s late answer can no longer come.
    pub(super) fn wait_until_quiet(&mut self, board: u8) -> Result<(), LineError> {
        let mut unsolicited = UnsolicitedReceiver::new();
        loop {
            let until_ns = self.ready_at_ns(board);
            if self.line.now_ns() >= until_ns {
                return Ok(());
            }
            let mut bytes = [0; BUFFER];
            let count = self.line.receive(&mut bytes, BUFFER, until_ns)?;
            self.discard(&mut unsolicited, &bytes[..count]);
        }
    }

    fn discard(&mut self, unsolicited: &mut UnsolicitedReceiver, bytes: &[u8]) {
        let now_ns = self.line.now_ns();
        self.unsolicited_bytes += bytes.len() as u64;
        self.last_byte = bytes.last().copied().or(self.last_byte);
        for &byte in bytes {
            if let Some(packet) = unsolicited.push(byte) {
                self.peers[usize::from(packet.address.board())].heard_late(now_ns);
            }
        }
    }
}

fn waited(since_ns: u64, now_ns: u64) -> Duration {
    Duration::from_nanos(now_ns - since_ns)
}

/// What is heard in one exchange.
struct AnswerReceiver {
    asked: Address,
    decoder: AnswerDecoder,
    heard: HeardBytes,
    answer: Option<[Counts; CHANNELS]>,
    other: Option<Packet>,
}

impl AnswerReceiver {
    /// The request's bytes, and the receiver of what follows them.
    fn for_question(
        question: Question,
        session: Option<Session>,
        echo: Echo,
        guard_echo_due: bool,
    ) -> ([u8; PACKET_LEN], Self) {
        let decoder = match question {
            Question::Pressures(request, PacketFormat::Unchecked) => AnswerDecoder::new(request, echo),
            Question::Pressures(packet, PacketFormat::Checked(sequence)) => {
                AnswerDecoder::for_checked(CheckedPacket { packet, sequence }, echo)
            }
            Question::Pressures(packet, PacketFormat::Sealed(seal)) => {
                AnswerDecoder::for_sealed(packet, seal, echo)
            }
            Question::Page(request) => AnswerDecoder::for_page(request, echo),
        };
        let bytes = decoder.request_bytes();
        let decoder = with_guard(decoder.in_session(session), guard_echo_due);
        let asked = question.address();
        (bytes, Self { asked, decoder, heard: HeardBytes::default(), answer: None, other: None })
    }

    /// Takes a byte; gives a packet that is not the answer.
    ///
    /// Two answers of the board that was asked, one behind the other: the first was late, the
    /// second is the answer.
    fn push(&mut self, byte: u8) -> Option<Packet> {
        self.heard.push(byte);
        match self.decoder.push(byte)? {
            Heard::Answer(values) => {
                let earlier = self.answer.replace(values)?;
                Some(Packet { address: self.asked, values: earlier })
            }
            Heard::Other(packet) => {
                self.other = Some(packet);
                Some(packet)
            }
        }
    }

    fn accepted_answer(&self) -> Option<[Counts; CHANNELS]> {
        self.answer.filter(|_| !self.decoder.echo_damaged())
    }

    fn failure(&self, waited: Duration) -> ExchangeError {
        let (asked, heard) = (self.asked, self.heard);
        if heard.count() == 0 {
            return ExchangeError::NoAnswer { asked, waited };
        }
        if self.decoder.echo_damaged() {
            return ExchangeError::EchoDamaged { asked, heard, waited };
        }
        match self.decoder.echo_left() {
            0 => {}
            missing => return ExchangeError::EchoMissing { asked, missing, heard, waited },
        }
        if self.other.is_some_and(|other| other.address == asked) {
            return ExchangeError::Stale { asked, waited };
        }
        if let Some(other) = self.other {
            return ExchangeError::OtherBoard { asked, answered: other.address, waited };
        }
        match self.decoder.stray_bytes() {
            0 => ExchangeError::NoAnswer { asked, waited },
            _ => ExchangeError::Garbled { asked, heard, waited },
        }
    }
}

/// What is heard while nobody has been asked.
struct UnsolicitedReceiver {
    heard: HeardBytes,
    finder: FrameFinder,
}

impl UnsolicitedReceiver {
    fn new() -> Self {
        Self { heard: HeardBytes::default(), finder: FrameFinder::new() }
    }

    /// Takes a byte; gives the packet that it completes, whoever's it is.
    fn push(&mut self, byte: u8) -> Option<Packet> {
        self.heard.push(byte);
        self.finder.push(byte).map(|frame| frame.packet())
    }
}
