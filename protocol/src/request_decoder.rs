use crate::frame::{Frame, FrameFinder, FrameStatistics};
use crate::{
    Address, CHANNELS, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, PageRequest, RequestNumber,
    Seal, Sequence, Session,
};

/// In which format a request came, and its answer goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PacketFormat {
    /// The original's: nothing guards the values.
    Unchecked,
    /// With a CRC and this sequence number.
    Checked(Sequence),
    /// The same in a session.
    Sealed(Seal),
}

/// What a board has been asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Asked {
    /// Its pressures, for new commands.
    Pressures(Request),
    /// An entry of a page. It commands nothing, and says nothing of who commands the board.
    Page(PageRequest),
}

impl Asked {
    /// The request with commands, if it is one.
    pub fn pressures(self) -> Option<Request> {
        match self {
            Self::Pressures(request) => Some(request),
            Self::Page(_) => None,
        }
    }
}

/// A request to this board with commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Request {
    /// Commands of channels 0 to 3.
    pub commands: [Counts; CHANNELS],
    /// The format that the answer must have, too.
    pub format: PacketFormat,
}

impl Request {
    /// Whether the host says with it that it leaves: see [`CheckedPacket::leave`].
    pub fn is_leave(&self) -> bool {
        self.format != PacketFormat::Unchecked && self.commands == CheckedPacket::LEAVE
    }

    /// The ten bytes of the answer to it: the board's pressures, in the request's own format and
    /// with its number.
    pub fn answer(&self, address: Address, pressures: [Counts; CHANNELS]) -> [u8; PACKET_LEN] {
        let packet = Packet { address, values: pressures };
        match self.format {
            PacketFormat::Unchecked => packet.encode(),
            PacketFormat::Checked(sequence) => CheckedPacket { packet, sequence }.encode(Direction::Answer),
            PacketFormat::Sealed(seal) => {
                let sequence = seal.number().sequence();
                CheckedPacket { packet, sequence }.encode_sealed(Direction::Answer, seal)
            }
        }
    }
}

/// A board's ear: finds the requests to its own address among everything that is said on the bus.
///
/// Feed it every byte in order; tell it when the line was silent for
/// [`IDLE_GAP_CHARACTERS`](crate::IDLE_GAP_CHARACTERS) and when the receiver flagged a byte as
/// damaged.
///
/// It never mixes formats. The first checked request shows that the host speaks the checked format,
/// and from then on unchecked ones are ignored: what looks like one may be a checked one whose
/// damage is not noticed. The first command of a [`Session`] that was [offered](Self::offer) shows
/// that the host knows sessions, and from then on only requests of that session are given, each
/// once. The host is forgotten by [`forget_host`](Self::forget_host), and when it says that it
/// leaves ([`CheckedPacket::leave`]): that request is given like any other, as four commands of 0
/// counts, which vent. A page request leaves this as it is.
#[derive(Debug, Clone)]
pub struct RequestDecoder {
    own: Address,
    finder: FrameFinder,
    host_checks: bool,
    session: Option<HeldSession>,
    damaged: u32,
}

/// A session that was offered to a host.
#[derive(Debug, Clone, Copy)]
struct HeldSession {
    session: Session,
    /// Number of the last request in it.
    last: RequestNumber,
    /// The host has taken it up.
    begun: bool,
}

impl HeldSession {
    fn seal(&self, sequence: Sequence) -> Option<Seal> {
        Some(self.session.seal(self.last.following(sequence)?))
    }
}

impl RequestDecoder {
    /// For the board with this address.
    pub fn new(own: Address) -> Self {
        Self { own, finder: FrameFinder::new(), host_checks: false, session: None, damaged: 0 }
    }

    /// Takes one byte; gives the request to this board that it completes.
    #[inline]
    pub fn push(&mut self, byte: u8) -> Option<Asked> {
        if self.finder.continues_with(byte) {
            return None;
        }
        self.decide(byte)
    }

    /// The byte completes a packet, or fits none.
    fn decide(&mut self, byte: u8) -> Option<Asked> {
        let (own, held) = (self.own, self.session);
        let seal = |address, sequence| held.filter(|_| address == own)?.seal(sequence);
        let Some(frame) = self.finder.push_with(byte, self.host_checks.then_some(own), seal) else {
            self.note_damage();
            return None;
        };
        let packet = frame.packet();
        if packet.address != self.own {
            return None;
        }
        let format = match frame {
            Frame::Unchecked(_) if self.host_checks => return None,
            Frame::Unchecked(_) => PacketFormat::Unchecked,
            Frame::Checked(_, Direction::Request) if self.in_session() => return None,
            Frame::Checked(checked, Direction::Request) => {
                self.host_checks = !checked.is_leave();
                PacketFormat::Checked(checked.sequence)
            }
            Frame::Sealed(checked, Direction::Request, seal) => {
                self.host_checks = !checked.is_leave();
                let session = held.filter(|_| !checked.is_leave());
                self.session = session.map(|held| HeldSession { last: seal.number(), begun: true, ..held });
                PacketFormat::Sealed(seal)
            }
            Frame::PageRequest(request) => return self.page(request),
            Frame::Checked(_, Direction::Answer)
            | Frame::Sealed(_, Direction::Answer, _)
            | Frame::PageAnswer(_) => return None,
        };
        Some(Asked::Pressures(Request { commands: packet.values, format }))
    }

    /// A session begins with a command: until then its host could be silent for ever without being
    /// forgotten.
    fn page(&mut self, request: PageRequest) -> Option<Asked> {
        if let Some(seal) = request.seal {
            let held = self.session.as_mut().filter(|held| held.begun)?;
            held.last = seal.number();
        }
        Some(Asked::Page(request))
    }

    fn note_damage(&mut self) {
        let own = self.finder.take_unverified() == Some(self.own);
        // Of a host that does not check any bytes may be meant.
        if own && self.host_checks {
            self.damaged = self.damaged.saturating_add(1);
        }
    }

    /// Gives the session with this number to whoever asked for one, unless a host is in one: then
    /// this is false.
    ///
    /// Until the host begins it with a command, requests without a session are given as before.
    pub fn offer(&mut self, number: u32) -> bool {
        if self.in_session() {
            return false;
        }
        let session = Session::new(self.own, number);
        self.session = Some(HeldSession { session, last: RequestNumber::default(), begun: false });
        true
    }

    /// Whether a host has begun the session that it was given.
    pub fn in_session(&self) -> bool {
        self.session.is_some_and(|held| held.begun)
    }

    /// Packets with this board's address whose CRC did not fit, since a host that checks was heard:
    /// damaged, repeated, of another session, or meant for another board.
    pub fn damaged_requests(&self) -> u32 {
        self.damaged
    }

    /// The line was silent: the next byte starts a frame.
    pub fn line_idle(&mut self) {
        self.finder.restart();
    }

    /// The receiver flagged a byte (framing, parity, overrun, break): the frame it belonged to is
    /// lost.
    pub fn line_error(&mut self) {
        self.finder.restart();
    }

    /// The host has been silent for so long that the next one may be another, of either kind.
    pub fn forget_host(&mut self) {
        self.host_checks = false;
        self.session = None;
    }

    /// The address it listens to.
    pub fn address(&self) -> Address {
        self.own
    }

    /// Packets heard (for any board) and bytes discarded.
    pub fn statistics(&self) -> FrameStatistics {
        self.finder.statistics()
    }
}
