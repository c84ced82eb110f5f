//! A board at another line rate: that it is asked for properly, and that it changes nothing else.

use crate::common::{Bench, packet};
use pneudrive_control::{BoardState, Micros};
use pneudrive_protocol::pages::{
    Entry, LineRate, LineRateAnswer, LineRateState, PageEntry, RateReturn, SessionOffer,
};
use pneudrive_protocol::{
    AnswerDecoder, Baud, CheckedPacket, Direction, Echo, Heard, PageRequest, RequestNumber, Sequence, Session,
};

/// A host in a session with the board.
struct Host {
    bench: Bench,
    session: Option<(Session, RequestNumber)>,
}

impl Host {
    fn new() -> Self {
        let mut host = Self { bench: Bench::running(), session: None };
        match SessionOffer::from_entry(host.ask(PageEntry::Session(7)).unwrap()) {
            Some(SessionOffer::Number(number)) => {
                let session = Session::new(host.bench.board.address(), number);
                host.session = Some((session, RequestNumber::default()));
            }
            other => panic!("{other:?}"),
        }
        host.command([102; 4]);
        host
    }

    fn now(&self) -> Micros {
        Micros::new(self.bench.now_us)
    }

    /// The answer is on the wire for 0.12 ms; then the board may change its rate.
    fn exchange(&mut self, bytes: [u8; 10]) -> Option<[u8; 10]> {
        let answer = self.bench.raw_bytes(&bytes).pop();
        self.bench.wait_us(120);
        if answer.is_some() {
            let now = self.now();
            let _ = self.bench.board.port().answer_sent(now);
        }
        answer
    }

    fn ask(&mut self, entry: PageEntry) -> Option<Entry> {
        let plain = PageRequest::new(self.bench.board.address(), entry, Sequence::new(3));
        let request = match &mut self.session {
            None => plain,
            Some((session, number)) => {
                *number = number.next();
                plain.sealed(session.seal(*number))
            }
        };
        let answer = self.exchange(request.encode())?;
        let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
        match answer.into_iter().find_map(|byte| decoder.push(byte)) {
            Some(Heard::Answer(words)) => Some(words),
            other => panic!("{entry:?}: {other:?}"),
        }
    }

    fn ask_for(&mut self, rate: LineRate) -> Option<LineRateAnswer> {
        LineRateAnswer::from_entry(self.ask(PageEntry::SetLineRate(rate))?)
    }

    fn state(&mut self) -> LineRateState {
        LineRateState::from_entry(self.ask(PageEntry::LineRate).unwrap()).unwrap()
    }

    fn command(&mut self, commands: [u16; 4]) {
        let (session, number) = self.session.as_mut().unwrap();
        *number = number.next();
        let checked = CheckedPacket { packet: packet(0, commands), sequence: number.sequence() };
        let bytes = checked.encode_sealed(Direction::Request, session.seal(*number));
        assert!(self.exchange(bytes).is_some(), "{commands:?}");
    }

    /// A control step, after which the firmware looks after the line rate.
    fn step(&mut self) -> ([i16; 4], BoardState) {
        let drives = self.bench.step();
        let now = self.now();
        let _ = self.bench.board.port().line_rate_due(now);
        (drives, self.bench.board.status().state)
    }
}

#[test]
fn a_rate_is_changed_in_a_session_after_the_answer_and_told() {
    let mut host = Host::new();
    let (session, before) = (host.session.take(), host.state());
    assert_eq!((before.now, before.fastest), (LineRate::Compiled, LineRate::ThreeMbaud));
    assert_eq!(host.ask_for(LineRate::ThreeMbaud), Some(LineRateAnswer::NeedsSession));
    assert_eq!(host.bench.board.baud(), Baud::ORIGINAL);
    host.session = session;
    assert_eq!(host.ask_for(LineRate::ThreeMbaud), Some(LineRateAnswer::Taken));
    assert_eq!(host.bench.board.baud(), Baud::THREE_MBAUD);
    assert_eq!(host.state().now, LineRate::ThreeMbaud);
    assert_eq!(host.ask_for(LineRate::Compiled), Some(LineRateAnswer::Taken));
    assert_eq!(host.bench.board.baud(), Baud::ORIGINAL);
    assert_eq!((host.state().returns, host.state().last_return), (0, None));
}

/// A gap is three characters of the rate in effect: 8 us are one at 3 Mbaud with the character, and
/// none at 1 Mbaud.
#[test]
fn gaps_are_those_of_the_rate() {
    let mut host = Host::new();
    host.ask_for(LineRate::ThreeMbaud);
    let (session, number) = host.session.unwrap();
    let request = |number: RequestNumber, values| {
        let checked = CheckedPacket { packet: packet(0, values), sequence: number.sequence() };
        checked.encode_sealed(Direction::Request, session.seal(number))
    };
    let bytes = request(number.next(), [200; 4]);
    for (gap_us, whole) in [(9, true), (12, false)] {
        let mut board = host.bench.board.clone();
        let mut now_us = host.bench.now_us + 1_000;
        let mut answered = false;
        for (n, byte) in bytes.into_iter().enumerate() {
            now_us += if n == 5 { gap_us } else { 3 };
            answered |= board.receive_byte(Micros::new(now_us), byte).is_some();
        }
        assert_eq!(answered, whole, "{gap_us} us");
    }
}

/// The same story for a board that has been raised and for one that has not: commands, then a host
/// that dies.
#[test]
fn a_host_that_dies_is_answered_by_hold_and_vent_as_at_the_compiled_rate() {
    let (mut raised, mut plain) = (Host::new(), Host::new());
    for host in [&mut raised, &mut plain] {
        host.bench.read(300);
    }
    assert_eq!(raised.ask_for(LineRate::ThreeMbaud), Some(LineRateAnswer::Taken));
    assert_eq!(plain.state().now, LineRate::Compiled, "so that both have been asked as often");
    for host in [&mut raised, &mut plain] {
        host.command([500; 4]);
    }
    let mut states = Vec::new();
    for ms in 0..3_000_u64 {
        let (now, then) = (raised.step(), plain.step());
        assert_eq!(now, then, "after {ms} ms");
        if states.last().is_none_or(|(_, state)| *state != now.1) {
            states.push((ms, now.1));
        }
        let wanted = if ms < 99 { Baud::THREE_MBAUD } else { Baud::ORIGINAL };
        assert!((98..=100).contains(&ms) || raised.bench.board.baud() == wanted, "after {ms} ms");
    }
    let kinds: Vec<_> = states.iter().map(|(_, state)| *state).collect();
    assert_eq!(kinds, [BoardState::Running, BoardState::Hold, BoardState::Vent]);
    raised.session = None;
    assert_eq!((raised.state().returns, raised.state().last_return), (1, Some(RateReturn::Silence)));
}

/// Pages alone keep a rate, but no set point: what only commands can do stays so.
#[test]
fn pages_at_a_new_rate_are_no_commands() {
    let mut host = Host::new();
    host.bench.read(300);
    host.ask_for(LineRate::ThreeMbaud);
    host.command([500; 4]);
    let mut last = BoardState::Running;
    for _ in 0..300 {
        // Every 10 ms.
        (0..10).for_each(|_| last = host.step().1);
        let answered = host.ask(PageEntry::LineRate);
        if answered.is_none() {
            host.session = None;
        }
    }
    assert_eq!(last, BoardState::Vent);
    assert_eq!(host.bench.board.baud(), Baud::THREE_MBAUD);
}

#[test]
fn when_the_host_leaves_the_next_one_finds_the_board_at_the_compiled_rate() {
    let mut host = Host::new();
    host.ask_for(LineRate::TwoMbaud);
    host.command([0; 4]);
    assert_eq!(host.bench.board.baud(), Baud::ORIGINAL);
    assert_eq!(host.bench.board.status().commands.map(|command| command.get()), [0; 4]);
}
