use super::run::Boards;
use pneudrive_host::bus::FormatPolicy;
use pneudrive_host::line::{Line, LineError};
use pneudrive_protocol::{Address, CheckedPacket, Counts, Direction, PACKET_LEN, Packet, Sequence};

/// Whole requests that the host has not sent to the board that hears them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stranger {
    /// Somebody repeats one of the host's last 40 requests.
    Replay,
    /// A request reaches the wire with the other board's address, and the CRC that fits it.
    SwappedBoard,
    /// Another host sends a request of its own, in packets as the host's before sessions.
    SecondHost,
}

impl Stranger {
    /// In the order of the table.
    pub const ALL: [Self; 3] = [Self::Replay, Self::SwappedBoard, Self::SecondHost];

    /// As it stands in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Replay => "replay",
            Self::SwappedBoard => "swapped board",
            Self::SecondHost => "second host",
        }
    }
}

/// In what the host of the table speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Speech {
    /// In which packets.
    pub frames: FormatPolicy,
    /// And whether in sessions.
    pub sessions: bool,
}

impl Speech {
    /// In the order of the table's cells.
    pub const ALL: [Self; 3] = [
        Self { frames: FormatPolicy::Unchecked, sessions: false },
        Self { frames: FormatPolicy::Checked, sessions: false },
        Self { frames: FormatPolicy::Checked, sessions: true },
    ];
}

/// A line on which every twentieth request meets a stranger.
#[derive(Debug)]
pub(super) struct LineWithStranger<L> {
    line: L,
    stranger: Stranger,
    frames: FormatPolicy,
    sent: Vec<[u8; PACKET_LEN]>,
    requests: usize,
    /// How often the stranger spoke.
    pub struck: u64,
}

impl<L: Line> LineWithStranger<L> {
    const EVERY: usize = 20;
    const KEPT: usize = 40;
    /// After the session has begun: what a host asks before that commands nothing.
    const AFTER: usize = 100;
    /// A request, an answer, and a gap.
    const PAUSE_NS: u64 = 400_000;

    pub(super) fn new(line: L, stranger: Stranger, frames: FormatPolicy) -> Self {
        Self { line, stranger, frames, sent: Vec::new(), requests: 0, struck: 0 }
    }

    /// The stranger speaks while the bus is quiet; nobody listens to what is answered.
    fn says(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.line.send(bytes)?;
        self.line.sleep_until(self.line.now_ns() + Self::PAUSE_NS);
        let now_ns = self.line.now_ns();
        self.line.receive(&mut [0; 512], 0, now_ns)?;
        Ok(())
    }

    fn request_of_its_own(&self) -> [u8; PACKET_LEN] {
        let board = u8::from(self.struck.is_multiple_of(2));
        let packet = Packet { address: Address::of_board(board), values: [Counts::saturating(950); 4] };
        match self.frames {
            FormatPolicy::Unchecked => packet.encode(),
            _ => {
                let sequence = Sequence::new(self.struck as u8);
                CheckedPacket { packet, sequence }.encode(Direction::Request)
            }
        }
    }

    /// `request` with the other board's address. CRCs are linear: what the address changes in one
    /// it changes in all.
    fn swapped(&self, request: [u8; PACKET_LEN]) -> [u8; PACKET_LEN] {
        let board = 0xFF - request[1];
        let to = |board| {
            let packet = Packet { address: Address::of_board(board), values: [Counts::MIN; 4] };
            match self.frames {
                FormatPolicy::Unchecked => packet.encode(),
                _ => CheckedPacket { packet, sequence: Sequence::new(1) }.encode(Direction::Request),
            }
        };
        let (from, to) = (to(board), to(1 - board));
        std::array::from_fn(|n| request[n] ^ from[n] ^ to[n])
    }
}

impl<L: Line> Line for LineWithStranger<L> {
    fn now_ns(&self) -> u64 {
        self.line.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        let Ok(request) = <[u8; PACKET_LEN]>::try_from(bytes) else { return self.line.send(bytes) };
        self.requests += 1;
        self.sent.push(request);
        if self.requests < Self::AFTER || !self.requests.is_multiple_of(Self::EVERY) {
            return self.line.send(bytes);
        }
        self.struck += 1;
        match self.stranger {
            Stranger::Replay => {
                let ago = 2 + self.struck as usize * 7 % (Self::KEPT - 1);
                self.says(&self.sent[self.sent.len() - ago].clone())?;
            }
            Stranger::SwappedBoard => return self.line.send(&self.swapped(request)),
            Stranger::SecondHost => self.says(&self.request_of_its_own())?,
        }
        self.line.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        self.line.receive(into, wanted, deadline_ns)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        self.line.sleep_until(at_ns);
    }
}

/// The second table's head. In every cell: unchecked packets / checked packets / in a session.
pub const STRANGERS_HEADER: &str = "\
| who | boards | struck | exchanges tried | lost | wrong commands obeyed |
| --- | --- | --- | --- | --- | --- |
";

const BEGIN: &str = "<!-- the table of strangers: made by the command above, do not edit -->\n";
const END: &str = "<!-- the table of strangers ends -->\n";

/// What came of a stranger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Met {
    /// How often it spoke.
    pub struck: u64,
    /// Requests sent.
    pub tried: u64,
    /// Requests without an answer that the host accepted.
    pub lost: u64,
    /// Requests obeyed that the host had not sent to that board, or had sent before.
    pub wrong_commands: u64,
}

/// A row of the table.
pub fn strangers_row(stranger: Stranger, boards: Boards, met: &[Met; 3]) -> String {
    let cell = |of: fn(&Met) -> u64| met.each_ref().map(|met| of(met).to_string()).join(" / ");
    format!(
        "| {} | {} | {} | {} | {} | {} |\n",
        stranger.name(),
        boards.name(),
        cell(|met| met.struck),
        cell(|met| met.tried),
        cell(|met| met.lost),
        cell(|met| met.wrong_commands),
    )
}

/// `page` with this table in its place; `None` if it has no such place.
pub fn strangers_written_into(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}{table}{END}{after}"))
}
