use super::{BusCounters, Line, Talker};
use pneudrive_protocol::{Address, PACKET_LEN};

/// Watches who speaks when, and counts what a real bus would answer with garbage or with luck.
///
/// It sees start bits in order of time per talker, and judges a board by its own address.
#[derive(Debug)]
pub(super) struct Referee {
    line: Line,
    strict: bool,
    host: HostSide,
    boards: Vec<Speech>,
}

/// What the host said last.
#[derive(Debug, Default)]
struct HostSide {
    window: [u8; PACKET_LEN],
    len: usize,
    quiet_since_ns: Option<u64>,
    /// The board that was asked and has not begun to answer.
    asked: Option<Address>,
}

/// One board's current or last answer.
#[derive(Debug)]
struct Speech {
    address: Address,
    first_ns: u64,
    last_end_ns: u64,
    characters: usize,
    overlong: bool,
}

/// What the bus must do about a character that a board begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The 555 covers it.
    Driven,
    /// The 555's pulse ends before the stop bit does: receivers see a damaged character.
    CutOff,
}

impl Referee {
    pub fn new(line: Line, strict: bool, addresses: impl IntoIterator<Item = Address>) -> Self {
        let boards = addresses.into_iter().map(Speech::none).collect();
        Self { line, strict, host: HostSide::default(), boards }
    }

    pub fn collision(&self, counters: &mut BusCounters, talker: Talker, with: Talker, now_ns: u64) {
        counters.collisions += 1;
        self.object(now_ns, format_args!("{talker} began while {with} spoke"));
    }

    pub fn host_begins(&mut self, counters: &mut BusCounters, byte: u8, line: &Line, start_ns: u64) {
        counters.host_characters += 1;
        for index in 0..self.boards.len() {
            self.close_answer(counters, index, start_ns);
        }
        let silence_ns = self.host.quiet_since_ns.map_or(0, |end| start_ns.saturating_sub(end));
        if silence_ns >= line.idle_gap_ns() {
            self.host.len = 0;
        }
        self.host.quiet_since_ns = Some(start_ns + line.character_ns());
        if let Some(address) = self.host.push(byte) {
            counters.requests += 1;
            self.host.asked = Some(address);
        }
    }

    pub fn board_begins(
        &mut self,
        counters: &mut BusCounters,
        index: usize,
        line: &Line,
        start_ns: u64,
    ) -> Verdict {
        counters.board_characters += 1;
        let end_ns = start_ns + line.character_ns();
        let pulse = self.line.pulse();
        let talker = Talker::Board(index);
        let speech = &self.boards[index];
        let pause_ns = start_ns.saturating_sub(speech.last_end_ns);
        let contiguous = speech.characters > 0 && pause_ns <= line.bit_ns();
        let unfinished = speech.characters > 0 && speech.characters < PACKET_LEN;

        if !contiguous && !unfinished {
            self.answer_begins(counters, index, start_ns);
        } else if !contiguous {
            counters.gaps += 1;
            self.object(start_ns, format_args!("{talker} paused {pause_ns} ns inside its answer"));
        }

        let speech = &mut self.boards[index];
        speech.characters += 1;
        speech.last_end_ns = end_ns;
        if speech.characters == PACKET_LEN {
            counters.answers += 1;
        }
        let spoken_ns = end_ns - speech.first_ns;
        if !speech.overlong && (speech.characters > PACKET_LEN || spoken_ns > pulse.shortest_ns) {
            speech.overlong = true;
            let characters = speech.characters;
            counters.overlong += 1;
            let limit_ns = pulse.shortest_ns;
            self.object(
                start_ns,
                format_args!("{talker}'s answer: {characters} characters, {spoken_ns} ns of {limit_ns} ns"),
            );
        }
        if spoken_ns > pulse.nominal_ns { Verdict::CutOff } else { Verdict::Driven }
    }

    /// The board's address is this from now on.
    pub fn set_address(&mut self, index: usize, address: Address) {
        self.boards[index].address = address;
    }

    /// When the answer that is being given ends, if it has ten characters.
    pub fn answer_ends_at_ns(&self, now_ns: u64) -> Option<u64> {
        let speaking = |speech: &&Speech| speech.last_end_ns > now_ns && speech.characters < PACKET_LEN;
        let ends = |speech: &Speech| speech.first_ns + self.line.characters_ns(PACKET_LEN as u64);
        self.boards.iter().filter(speaking).map(ends).max()
    }

    fn answer_begins(&mut self, counters: &mut BusCounters, index: usize, start_ns: u64) {
        let talker = Talker::Board(index);
        let address = self.boards[index].address;
        self.boards[index] = Speech { first_ns: start_ns, ..Speech::none(address) };
        let allowed_ns = self.host.quiet_since_ns.map_or(0, |end| end + self.line.min_turnaround_ns);
        if start_ns < allowed_ns {
            counters.early += 1;
            self.object(start_ns, format_args!("{talker} answered {} ns early", allowed_ns - start_ns));
        }
        if self.host.asked == Some(address) {
            self.host.asked = None;
        } else {
            counters.unasked += 1;
            self.object(start_ns, format_args!("{talker} spoke without being asked"));
        }
    }

    /// The host speaks again: whatever a board was saying has ended.
    fn close_answer(&mut self, counters: &mut BusCounters, index: usize, now_ns: u64) {
        let speech = &mut self.boards[index];
        if speech.last_end_ns > now_ns {
            return; // Still speaking: a collision, and its answer goes on.
        }
        let characters = std::mem::take(&mut speech.characters);
        if characters > 0 && characters < PACKET_LEN {
            counters.truncated += 1;
            let talker = Talker::Board(index);
            self.object(now_ns, format_args!("{talker}'s answer ended after {characters} characters"));
        }
    }

    fn object(&self, now_ns: u64, what: std::fmt::Arguments<'_>) {
        assert!(!self.strict, "bus violation at {now_ns} ns: {what}");
    }
}

impl Speech {
    fn none(address: Address) -> Self {
        Self { address, first_ns: 0, last_end_ns: 0, characters: 0, overlong: false }
    }
}

impl HostSide {
    /// Takes a byte; gives the address when the last ten are a packet of either format (bit 15 of
    /// every value word is 0).
    fn push(&mut self, byte: u8) -> Option<Address> {
        if self.len == PACKET_LEN {
            self.window.rotate_left(1);
            self.len -= 1;
        }
        self.window[self.len] = byte;
        self.len += 1;
        let values_ok = self.window[2..].chunks_exact(2).all(|word| word[0] < 0x80);
        if self.len < PACKET_LEN || !values_ok {
            return None;
        }
        let address = Address::from_word(u16::from_be_bytes([self.window[0], self.window[1]]))?;
        self.len = 0;
        Some(address)
    }
}
