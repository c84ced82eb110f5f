use pneudrive_protocol::{Address, CHANNELS, Counts, PACKET_LEN, Packet, Sequence};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What was really said, and what others made of it.
#[derive(Debug)]
pub struct Truth {
    boards: Vec<BoardTruth>,
}

#[derive(Debug, Default)]
struct BoardTruth {
    /// Requests to it that it has not obeyed, oldest first.
    sent: VecDeque<Sent>,
    /// Its last answers, newest last.
    said: VecDeque<Said>,
    /// When the command that its valves act on was sent, and when it was heard, ns; none while they
    /// vent.
    acting: Option<(u64, u64)>,
    /// Before this it vents, because it has just been powered, ns.
    vents_until_ns: u64,
    oldest_command_ns: u64,
    wrong_commands: u64,
    wrong_pressures: u64,
}

#[derive(Debug, Clone, Copy)]
struct Sent {
    at_ns: u64,
    words: Words,
}

#[derive(Debug, Clone, Copy)]
struct Said {
    at_ns: u64,
    pressures: [Counts; CHANNELS],
}

/// What a packet says, in either format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Words {
    pub packet: Packet,
    pub sequence: Option<Sequence>,
}

impl Words {
    /// By the form alone: the CRC of a packet in a session can only be checked with the session's
    /// number.
    pub(super) fn of(bytes: &[u8; PACKET_LEN]) -> Option<Self> {
        if let Ok(packet) = Packet::decode(bytes) {
            return Some(Self { packet, sequence: None });
        }
        let mut words = bytes.as_chunks::<2>().0.iter().map(|word| u16::from_be_bytes(*word));
        let address = Address::from_word(words.next()?)?;
        let data: [u16; CHANNELS] = words.collect::<Vec<_>>().try_into().ok()?;
        if data.iter().any(|word| word & 0x8000 != 0) {
            return None;
        }
        let packet = Packet { address, values: data.map(|word| Counts::saturating(word & 0x3FF)) };
        Some(Self { packet, sequence: Some(Sequence::new((data[0] >> 11) as u8)) })
    }
}

/// Shared between the host's line and the boards.
#[derive(Debug, Clone)]
pub struct SharedTruth(Arc<Mutex<Truth>>);

impl SharedTruth {
    /// Nothing has been said yet.
    pub fn new(boards: usize) -> Self {
        let boards = (0..boards).map(|_| BoardTruth::default()).collect();
        Self(Arc::new(Mutex::new(Truth { boards })))
    }

    /// To ask it.
    pub fn lock(&self) -> MutexGuard<'_, Truth> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Truth {
    /// A board that hears nothing for so long vents, ns: command timeout and hold.
    const GIVES_UP_AFTER_NS: u64 = 2_500_000_000;
    /// From the end of a request to the control step that obeys it, at the most, ns.
    const LOOP_NS: u64 = 1_000_000;
    /// Answers of a board that are remembered: the host looks at the end of its cycle.
    const SAID_KEPT: usize = 8;

    /// The host sends a request.
    pub(super) fn host_sends(&mut self, at_ns: u64, bytes: &[u8]) {
        let words = bytes.try_into().ok().and_then(Words::of);
        let Some(words) = words else { return };
        if let Some(board) = self.boards.get_mut(usize::from(words.packet.address.board())) {
            board.sent.push_back(Sent { at_ns, words });
        }
    }

    /// Board `index` obeys a request that it heard as `heard`; `None` if what it heard was no
    /// request to it at all.
    pub(super) fn board_obeys(&mut self, index: usize, now_ns: u64, heard: Option<Words>) {
        let board = &mut self.boards[index];
        let place = heard.and_then(|heard| board.sent.iter().rposition(|sent| sent.words == heard));
        let Some(place) = place else {
            board.wrong_commands += 1;
            return;
        };
        let sent_ns = board.sent[place].at_ns;
        board.sent.drain(..=place);
        board.age(now_ns);
        board.acting = Some((sent_ns, now_ns));
    }

    /// Board `index` answers.
    pub(super) fn board_says(&mut self, index: usize, at_ns: u64, pressures: [Counts; CHANNELS]) {
        let said = &mut self.boards[index].said;
        said.push_back(Said { at_ns, pressures });
        if said.len() > Self::SAID_KEPT {
            said.pop_front();
        }
    }

    /// Board `index` loses its supply, or has it back and vents until then.
    pub(super) fn board_vents(&mut self, index: usize, now_ns: u64, until_ns: u64) {
        let board = &mut self.boards[index];
        board.age(now_ns);
        board.acting = None;
        board.vents_until_ns = until_ns;
    }

    /// The host believes that board `index`, asked at `asked_ns`, has answered with `pressures`.
    pub(super) fn host_believes(&mut self, index: usize, asked_ns: u64, pressures: [Counts; CHANNELS]) {
        let board = &mut self.boards[index];
        let said = board.said.iter().any(|said| said.at_ns >= asked_ns && said.pressures == pressures);
        board.wrong_pressures += u64::from(!said);
    }

    /// The run has ended.
    pub fn end(&mut self, now_ns: u64) {
        self.boards.iter_mut().for_each(|board| board.age(now_ns));
    }

    /// Requests obeyed that the host had not sent to that board.
    pub fn wrong_commands(&self) -> u64 {
        self.boards.iter().map(|board| board.wrong_commands).sum()
    }

    /// Answers believed that the board had not given to that request.
    pub fn wrong_pressures(&self) -> u64 {
        self.boards.iter().map(|board| board.wrong_pressures).sum()
    }

    /// Greatest age of the command that a board's valves acted on, ns.
    pub fn oldest_command_ns(&self) -> u64 {
        self.boards.iter().map(|board| board.oldest_command_ns).max().unwrap_or(0)
    }
}

impl BoardTruth {
    /// The command that the valves act on has lasted until `now_ns`, or until they gave up.
    fn age(&mut self, now_ns: u64) {
        let Some((sent_ns, heard_ns)) = self.acting else { return };
        let until_ns = now_ns.min(heard_ns + Truth::GIVES_UP_AFTER_NS);
        if until_ns > self.vents_until_ns {
            self.oldest_command_ns = self.oldest_command_ns.max(until_ns + Truth::LOOP_NS - sent_ns);
        }
    }
}
