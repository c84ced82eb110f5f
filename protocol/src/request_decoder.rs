use crate::frame::{Frame, FrameFinder, FrameStatistics};
use crate::{Address, CHANNELS, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, PageRequest, Sequence};

/// In which of the two formats a request came, and its answer goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// The original's: nothing guards the values.
    Unchecked,
    /// With a CRC and this sequence number.
    Checked(Sequence),
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
    pub format: Format,
}

impl Request {
    /// The ten bytes of the answer to it: the board's pressures, in the request's own format and with its number.
    pub fn answer(&self, address: Address, pressures: [Counts; CHANNELS]) -> [u8; PACKET_LEN] {
        let packet = Packet { address, values: pressures };
        match self.format {
            Format::Unchecked => packet.encode(),
            Format::Checked(sequence) => CheckedPacket { packet, sequence }.encode(Direction::Answer),
        }
    }
}

/// A board's ear: finds the requests to its own address among everything that is said on the bus.
///
/// Feed it every byte in order; tell it when the line was silent for [`IDLE_GAP_CHARACTERS`](crate::IDLE_GAP_CHARACTERS)
/// and when the receiver flagged a byte as damaged.
///
/// It never mixes formats. The first checked request shows that the host speaks the checked format, and from then on
/// unchecked ones are ignored: what looks like one may be a checked one whose damage is not noticed. The host is
/// forgotten by [`forget_host`](Self::forget_host), and when it says that it leaves ([`CheckedPacket::leave`]): that request is
/// given like any other, as four commands of 0 counts, which vent. A page request leaves this as it is.
#[derive(Debug, Clone)]
pub struct RequestDecoder {
    own: Address,
    finder: FrameFinder,
    host_checks: bool,
}

impl RequestDecoder {
    /// For the board with this address.
    pub fn new(own: Address) -> Self {
        Self { own, finder: FrameFinder::new(), host_checks: false }
    }

    /// Takes one byte; gives the request to this board that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Asked> {
        let frame = self.finder.push(byte)?;
        let packet = frame.packet();
        if packet.address != self.own {
            return None;
        }
        let format = match frame {
            Frame::Unchecked(_) if self.host_checks => return None,
            Frame::Unchecked(_) => Format::Unchecked,
            Frame::Checked(checked, Direction::Request) => {
                self.host_checks = !checked.is_leave();
                Format::Checked(checked.sequence)
            }
            Frame::PageRequest(request) => return Some(Asked::Page(request)),
            Frame::Checked(_, Direction::Answer) | Frame::PageAnswer(_) => return None,
        };
        Some(Asked::Pressures(Request { commands: packet.values, format }))
    }

    /// The line was silent: the next byte starts a frame.
    pub fn line_idle(&mut self) {
        self.finder.restart();
    }

    /// The receiver flagged a byte (framing, parity, overrun, break): the frame it belonged to is lost.
    pub fn line_error(&mut self) {
        self.finder.restart();
    }

    /// The host has been silent for so long that the next one may be another, of either kind.
    pub fn forget_host(&mut self) {
        self.host_checks = false;
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
