use super::host::{HostReceiver, HostTransmitter};
use super::misheard::heard_at;
use super::referee::{Referee, Verdict};
use super::wire::{Contention, InFlight, Wire};
use super::{Air, BusCounters, BusNode, Character, HostByte, Line, Talker};
use crate::fault::{FaultInjector, LineEvent, Passage};
use pneudrive_protocol::Baud;

/// Host adapter, wire, boards, faults and the air behind the boards, advanced together.
pub struct Bus {
    now_ns: u64,
    line: Line,
    /// The wire at the host adapter's line rate.
    host_line: Line,
    wire: Wire,
    referee: Referee,
    counters: BusCounters,
    faults: FaultInjector,
    transmitter: HostTransmitter,
    receiver: HostReceiver,
    boards: Vec<Place>,
    air: Box<dyn Air + Send>,
}

/// A board's place on the bus.
struct Place {
    node: Box<dyn BusNode + Send>,
    plugged: bool,
    babbling: bool,
    /// The line rate to which it has gone, if it has.
    baud: Option<Baud>,
}

impl Bus {
    /// Boards on a line, at time 0. `strict` makes every violation a panic, for tests on a bus
    /// without faults.
    ///
    /// The board at position n has the n-th four channels of `air`, whatever its address is.
    pub fn new(
        line: Line,
        boards: Vec<Box<dyn BusNode + Send>>,
        air: Box<dyn Air + Send>,
        faults: FaultInjector,
        strict: bool,
    ) -> Self {
        Self {
            now_ns: 0,
            line,
            host_line: line,
            wire: Wire::new(),
            referee: Referee::new(line, strict, boards.iter().map(|node| node.address())),
            counters: BusCounters::default(),
            faults,
            transmitter: HostTransmitter::new(line),
            receiver: HostReceiver::default(),
            boards: boards
                .into_iter()
                .map(|node| Place { node, plugged: true, babbling: false, baud: None })
                .collect(),
            air,
        }
    }

    /// The time it has been run to, ns.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// How long bits last on it.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The host's adapter sends and listens at this line rate from now on; `None` is that of the
    /// rig. Whoever listens at another rate than is spoken at hears something else.
    pub fn set_host_baud(&mut self, baud: Option<Baud>) {
        let line = self.line.at_rate(baud);
        if line != self.host_line {
            self.host_line = line;
            self.transmitter.set_line(line);
            self.rates_changed();
        }
    }

    /// What has happened so far.
    pub fn counters(&self) -> &BusCounters {
        &self.counters
    }

    /// The host's adapter gets `bytes` to send at `at_ns`. It sends them back to back, after what
    /// it still has to send; never before the present time of the bus.
    pub fn send(&mut self, at_ns: u64, bytes: &[u8]) {
        let mut not_before_ns = at_ns.max(self.now_ns);
        for &byte in bytes {
            let Passage { copies, byte, hold_ns } =
                self.faults.host_to_wire(not_before_ns, byte, &mut self.counters);
            not_before_ns += hold_ns;
            for _ in 0..copies {
                self.transmitter.push(not_before_ns, byte);
            }
        }
    }

    /// The next byte that the host's adapter has handed over by now.
    pub fn receive(&mut self) -> Option<HostByte> {
        self.receiver.pop(self.now_ns)
    }

    /// Nothing is on the wire and the host has nothing left to send (a board may still be about to
    /// answer).
    pub fn is_quiet(&self) -> bool {
        self.wire.is_free() && self.transmitter.is_empty()
    }

    /// When something happens next if the host sends nothing, ns.
    pub fn next_event_ns(&self) -> u64 {
        let boards = self.boards.iter().map(|place| place.node.next_event_ns()).min();
        [
            self.wire.next_end_ns(),
            self.transmitter.next_start_ns(),
            self.receiver.next_at_ns().filter(|&at| at > self.now_ns),
            self.faults.next_event_ns(),
            boards,
        ]
        .into_iter()
        .flatten()
        .min()
        .unwrap_or(u64::MAX)
        .max(self.now_ns)
    }

    /// Before when the host has nothing to gain from looking, ns: a run of characters goes on,
    /// which ends then if it is a whole packet. `None` on a quiet bus.
    ///
    /// A hint for pacing, not a promise: boards may end early.
    pub fn run_ends_at_ns(&self) -> Option<u64> {
        if self.is_quiet() {
            return None;
        }
        let host_done_ns = self.transmitter.done_at_ns();
        if host_done_ns > self.now_ns {
            // What follows a request takes a character at least.
            return Some(host_done_ns + self.host_line.character_ns());
        }
        self.referee.answer_ends_at_ns(self.now_ns).or_else(|| self.wire.next_end_ns())
    }

    /// When the adapter hands over the next byte that it still holds back, ns.
    pub fn held_back_until_ns(&self) -> Option<u64> {
        self.receiver.next_at_ns().filter(|&at| at > self.now_ns)
    }

    /// A part of the plant's work up to the next event of a board; says whether any is left. See
    /// [`Air::work_ahead`].
    pub fn work_ahead(&mut self) -> bool {
        let boards = self.boards.iter().map(|place| place.node.next_event_ns()).min();
        let until_ns = boards.into_iter().chain(self.faults.next_event_ns()).min().unwrap_or(self.now_ns);
        self.air.work_ahead(until_ns)
    }

    /// Runs everything up to and including `until_ns`.
    pub fn run_until(&mut self, until_ns: u64) {
        loop {
            let next_ns = self.next_event_ns();
            if next_ns > until_ns {
                break;
            }
            self.now_ns = next_ns;
            self.apply_line_events();
            self.advance_boards();
            self.begin_host_characters();
            self.deliver_ended();
        }
        self.now_ns = self.now_ns.max(until_ns);
    }

    fn apply_line_events(&mut self) {
        while let Some(event) = self.faults.take_event(self.now_ns, &mut self.counters) {
            self.apply(event);
        }
        while let Some((talker, character)) = self.faults.take_character(self.now_ns) {
            if let Talker::Board(index) = talker
                && !self.boards.get(index).is_some_and(|place| place.plugged)
            {
                continue;
            }
            self.begin(talker, character);
        }
    }

    fn apply(&mut self, event: LineEvent) {
        let (index, now_ns) = (event.board(), self.now_ns);
        let Some(place) = self.boards.get_mut(index) else { return };
        match event {
            LineEvent::Unplugged { .. } => place.plugged = false,
            LineEvent::Replugged { .. } => place.plugged = true,
            LineEvent::BabbleBegins { .. } => place.babbling = true,
            LineEvent::BabbleEnds { .. } => place.babbling = false,
            LineEvent::PowerOff { .. } => place.node.set_powered(false, now_ns, self.air.as_mut()),
            LineEvent::PowerOn { .. } => place.node.set_powered(true, now_ns, self.air.as_mut()),
        }
    }

    fn advance_boards(&mut self) {
        for index in 0..self.boards.len() {
            let place = &mut self.boards[index];
            place.node.advance(self.now_ns, self.air.as_mut());
            let baud = place.node.baud();
            let changed = std::mem::replace(&mut place.baud, baud) != baud;
            // A babbling UART has no room for answers, and nobody hears an unplugged board.
            while let Some(character) = self.boards[index].node.transmit() {
                if self.boards[index].plugged && !self.boards[index].babbling {
                    self.begin(Talker::Board(index), character);
                }
            }
            if changed {
                self.rates_changed();
            }
        }
    }

    fn rates_changed(&mut self) {
        let boards = self.boards.iter().map(|place| self.line.at_rate(place.baud).character_ns());
        let shortest_ns = boards.chain([self.host_line.character_ns()]).min().unwrap_or(1);
        for place in &mut self.boards {
            place.node.set_shortest_character(shortest_ns);
        }
    }

    fn line_of(&self, talker: Talker) -> Line {
        match talker {
            Talker::Host => self.host_line,
            Talker::Board(index) => self.line.at_rate(self.boards.get(index).and_then(|place| place.baud)),
            Talker::Noise => self.line,
        }
    }

    fn begin_host_characters(&mut self) {
        while let Some((start_ns, byte, opens_burst)) = self.transmitter.take(self.now_ns) {
            self.faults.host_begins(start_ns, opens_burst);
            self.begin(Talker::Host, Character { start_ns, byte });
        }
    }

    fn begin(&mut self, talker: Talker, character: Character) {
        let line = self.line_of(talker);
        if let Contention::Begun { with } = self.wire.begin(talker, line, character) {
            self.referee.collision(&mut self.counters, talker, with, character.start_ns);
        }
        match talker {
            Talker::Host => {
                self.referee.host_begins(&mut self.counters, character.byte, &line, character.start_ns);
            }
            Talker::Board(index) => {
                // A host can have changed it.
                self.referee.set_address(index, self.boards[index].node.address());
                let verdict = self.referee.board_begins(&mut self.counters, index, &line, character.start_ns);
                if verdict == Verdict::CutOff {
                    self.wire.cut_off_last(talker);
                }
            }
            Talker::Noise => {}
        }
    }

    fn deliver_ended(&mut self) {
        while let Some(flight) = self.wire.take_ended(self.now_ns) {
            if !flight.absorbed {
                self.deliver(&flight);
            }
        }
    }

    fn deliver(&mut self, flight: &InFlight) {
        for (index, place) in self.boards.iter_mut().enumerate() {
            if place.plugged && flight.talker != Talker::Board(index) {
                let line = self.line.at_rate(place.baud);
                heard_at(&line, flight, |heard| place.node.receive(flight.end_ns, heard));
            }
        }
        let echoed = flight.talker == Talker::Host;
        if echoed && !self.faults.echoes(&mut self.counters) {
            return;
        }
        let (host_line, faults, counters) = (self.host_line, &mut self.faults, &mut self.counters);
        heard_at(&host_line, flight, |heard| {
            let Passage { copies, byte, hold_ns } = faults.wire_to_host(flight.end_ns, heard.byte, counters);
            let at_ns = flight.end_ns + hold_ns;
            for _ in 0..copies {
                self.receiver.push(HostByte { at_ns, byte, damaged: heard.damaged });
            }
        });
    }
}
