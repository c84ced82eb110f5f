use crate::false_address::GUARD;
use crate::frame::{Frame, FrameFinder};
use crate::{
    Address, CHANNELS, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, PageRequest, Seal, Sequence,
    Session,
};

/// Whether the host hears its own bytes.
///
/// Adapters whose receiver stays enabled while they send return every byte of a request. Content
/// cannot tell an echo from an answer (a board that holds its set points answers with the very
/// bytes of the request), so this is a property of the adapter, found out once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Echo {
    /// The first packet heard is the answer.
    #[default]
    Absent,
    /// As many bytes as were sent come back before the answer.
    Present,
}

/// A packet that the host heard while waiting for an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// The board that was asked answered: with these pressures, or to a page request with these
    /// words.
    Answer([Counts; CHANNELS]),
    /// Another packet: of another board, of another kind, or (from the board that was asked) with
    /// another sequence number, so the late answer to an earlier request.
    Other(Packet),
}

/// Of which kind the answer is, and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Unchecked,
    Checked(Sequence),
    Sealed(Seal),
    Page(Sequence),
    SealedPage(Seal),
}

impl Wanted {
    fn page(sequence: Sequence, seal: Option<Seal>) -> Self {
        seal.map_or(Self::Page(sequence), Self::SealedPage)
    }

    fn seal(self) -> Option<Seal> {
        match self {
            Self::Sealed(seal) | Self::SealedPage(seal) => Some(seal),
            Self::Unchecked | Self::Checked(_) | Self::Page(_) => None,
        }
    }
}

/// The host's ear for one exchange: made when a request has been sent, fed until the answer or the
/// timeout.
#[derive(Debug, Clone)]
pub struct AnswerDecoder {
    request: Packet,
    wanted: Wanted,
    sent: [u8; PACKET_LEN],
    echo_left: usize,
    echo_damaged: bool,
    /// The echo of a guard byte may come before that of the request.
    guard_echo: bool,
    answered_unchecked: bool,
    session: Option<Session>,
    finder: FrameFinder,
}

impl AnswerDecoder {
    /// For the answer to an unchecked `request`.
    pub fn new(request: Packet, echo: Echo) -> Self {
        Self::waiting_for(Wanted::Unchecked, request, request.encode(), echo)
    }

    /// For the answer to a checked `request`.
    pub fn for_checked(request: CheckedPacket, echo: Echo) -> Self {
        let wanted = Wanted::Checked(request.sequence);
        Self::waiting_for(wanted, request.packet, request.encode(Direction::Request), echo)
    }

    /// For the answer to `request` with this seal.
    pub fn for_sealed(request: Packet, seal: Seal, echo: Echo) -> Self {
        let checked = CheckedPacket { packet: request, sequence: seal.number().sequence() };
        let sent = checked.encode_sealed(Direction::Request, seal);
        Self::waiting_for(Wanted::Sealed(seal), request, sent, echo)
    }

    /// For the answer to a page request.
    pub fn for_page(request: PageRequest, echo: Echo) -> Self {
        let wanted = Wanted::page(request.sequence, request.seal);
        Self::waiting_for(wanted, request.packet(), request.encode(), echo)
    }

    /// The session that the request is of, if it is of one: late answers in it are then known for
    /// what they are.
    #[must_use]
    pub fn in_session(self, session: Option<Session>) -> Self {
        Self { session, ..self }
    }

    /// The ten bytes of the request.
    pub fn request_bytes(&self) -> [u8; PACKET_LEN] {
        self.sent
    }

    fn waiting_for(wanted: Wanted, request: Packet, sent: [u8; PACKET_LEN], echo: Echo) -> Self {
        let echo_left = match echo {
            Echo::Absent => 0,
            Echo::Present => PACKET_LEN,
        };
        Self {
            request,
            wanted,
            sent,
            echo_left,
            echo_damaged: false,
            guard_echo: false,
            answered_unchecked: false,
            session: None,
            finder: FrameFinder::new(),
        }
    }

    /// A [`GUARD`] byte was sent before the request, and its echo has not been heard yet. It is
    /// told from the request's echo by its value.
    #[must_use]
    pub fn after_guard(self) -> Self {
        Self { guard_echo: true, ..self }
    }

    /// Takes one byte; gives the packet that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Heard> {
        if self.echo_left > 0 {
            if core::mem::take(&mut self.guard_echo) && byte == GUARD {
                return None;
            }
            self.echo_damaged |= byte != self.sent[PACKET_LEN - self.echo_left];
            self.echo_left -= 1;
            return None;
        }
        let (asked, wanted, session) = (self.request.address, self.wanted.seal(), self.session);
        let seal = |address, sequence| {
            let wanted = wanted.filter(|_| address == asked)?;
            match wanted.number().latest(sequence) {
                number if number == wanted.number() => Some(wanted),
                earlier => Some(session?.seal(earlier)),
            }
        };
        let frame = self.finder.push_with(byte, None, seal)?;
        let packet = frame.packet();
        let came = match frame {
            Frame::Unchecked(_) => Wanted::Unchecked,
            Frame::Checked(checked, Direction::Answer) => Wanted::Checked(checked.sequence),
            Frame::Sealed(_, Direction::Answer, seal) => Wanted::Sealed(seal),
            Frame::PageAnswer(answer) => Wanted::page(answer.sequence, answer.seal),
            // An echo that nobody expected says what it is.
            Frame::Checked(_, Direction::Request)
            | Frame::Sealed(_, Direction::Request, _)
            | Frame::PageRequest(_) => return None,
        };
        Some(if packet.address == self.request.address && came == self.wanted {
            Heard::Answer(packet.values)
        } else {
            self.answered_unchecked |= packet.address == self.request.address && came == Wanted::Unchecked;
            Heard::Other(packet)
        })
    }

    /// Whether the echo differed from what was sent: somebody else spoke at the same time, or the
    /// line is noisy.
    pub fn echo_damaged(&self) -> bool {
        self.echo_damaged
    }

    /// Bytes of the request's echo that have not come, where one is expected.
    pub fn echo_left(&self) -> usize {
        self.echo_left
    }

    /// Whether the board that was asked in checked packets answered in the original's format, as
    /// boards of the original kind do.
    pub fn answered_unchecked(&self) -> bool {
        self.answered_unchecked
    }

    /// Bytes heard that belong to no valid packet so far (a started packet included).
    pub fn stray_bytes(&self) -> usize {
        self.finder.unpacked_bytes()
    }

    /// The board whose answer is awaited.
    pub fn expected(&self) -> Address {
        self.request.address
    }
}
