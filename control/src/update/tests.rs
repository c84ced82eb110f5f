use super::*;
use crate::{AdcSample, Board, BoardConfig, Micros};
use pneudrive_protocol::pages::{PageEntry, SessionOffer, number_in};
use pneudrive_protocol::{
    Address, AnswerDecoder, CheckedPacket, Counts, Direction, Echo, Heard, Packet, PageRequest,
    RequestNumber, Sequence, Session,
};
use std::vec::Vec;

const FLASHED: RunningProgram =
    RunningProgram { running: Running::Flashed, last_trial: LastTrial::None, crc: 0 };
const TRIAL: RunningProgram =
    RunningProgram { running: Running::TrialSecond, last_trial: LastTrial::None, crc: 5 };
const ADDRESS: Address = Address::of_board(1);
const AIR: u16 = 102;

/// A board, and a host in a session with it.
#[derive(Clone)]
struct Bench {
    board: Board,
    now_us: u64,
    inbox: Vec<u8>,
    session: Option<(Session, RequestNumber)>,
    pressure: u16,
}

impl Bench {
    fn new(program: Option<RunningProgram>) -> Self {
        let mut board = Board::new(BoardConfig::ORIGINAL, ADDRESS).unwrap();
        if let Some(program) = program {
            board.port().support_updates(program);
        }
        let mut bench = Self { board, now_us: 0, inbox: Vec::new(), session: None, pressure: AIR };
        bench.pass(3_000);
        bench
    }

    fn in_session(program: RunningProgram) -> Self {
        let mut bench = Self::new(Some(program));
        let offer = SessionOffer::from_entry(bench.ask(PageEntry::Session(7)));
        let Some(SessionOffer::Number(number)) = offer else { panic!("{offer:?}") };
        bench.session = Some((Session::new(ADDRESS, number), RequestNumber::default()));
        bench.command(AIR);
        bench
    }

    /// Control steps, one a millisecond.
    fn pass(&mut self, ms: u64) {
        for _ in 0..ms {
            self.now_us += 1_000;
            let sample = AdcSample::from_reading(4 * self.pressure);
            self.board.control_step(Micros::new(self.now_us), [sample; 4]);
        }
    }

    fn send(&mut self, bytes: [u8; 10]) -> Option<[u8; 10]> {
        self.now_us += 500;
        let mut answer = None;
        for byte in bytes {
            self.now_us += 10;
            answer = answer.or(self.board.receive_byte(Micros::new(self.now_us), byte));
            if let Some(piece) = self.board.port().take_piece() {
                self.inbox.resize(piece.offset, 0xAA);
                self.inbox.extend(piece.bytes);
            }
        }
        self.now_us += 490;
        answer
    }

    fn command(&mut self, counts: u16) {
        let packet = Packet { address: ADDRESS, values: [Counts::saturating(counts); 4] };
        let bytes = match &mut self.session {
            None => CheckedPacket { packet, sequence: Sequence::new(1) }.encode(Direction::Request),
            Some((session, number)) => {
                *number = number.next();
                CheckedPacket { packet, sequence: number.sequence() }
                    .encode_sealed(Direction::Request, session.seal(*number))
            }
        };
        assert!(self.send(bytes).is_some());
        self.pass(1);
    }

    fn request(&mut self, entry: PageEntry) -> PageRequest {
        let request = PageRequest::new(ADDRESS, entry, Sequence::new(3));
        match &mut self.session {
            None => request,
            Some((session, number)) => {
                *number = number.next();
                request.sealed(session.seal(*number))
            }
        }
    }

    fn ask(&mut self, entry: PageEntry) -> Entry {
        let request = self.request(entry);
        let answer = self.send(request.encode()).unwrap();
        let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
        match answer.into_iter().find_map(|byte| decoder.push(byte)) {
            Some(Heard::Answer(words)) => words,
            other => panic!("{entry:?}: {other:?}"),
        }
    }

    fn update(&mut self, update: Update) -> (UpdateReply, u32) {
        let answer = UpdateAnswer::from_entry(self.ask(PageEntry::Update(update))).unwrap();
        (answer.reply, answer.received)
    }

    fn state(&mut self) -> UpdateState {
        UpdateState::from_entry(self.ask(PageEntry::Program(UpdateEntry::State))).unwrap()
    }

    fn received(&mut self) -> Option<u32> {
        number_in(self.ask(PageEntry::Program(UpdateEntry::Received)))
    }
}

fn pieces(bytes: &[u8]) -> Vec<[u8; 3]> {
    bytes.chunks(3).map(|piece| core::array::from_fn(|n| piece.get(n).copied().unwrap_or(0))).collect()
}

/// A program that could be one, with its CRC.
fn program(chip: u8, length: usize) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..length).map(|n| (n * 37 % 251) as u8).collect();
    let length = length as u32;
    let words = [
        (0, 0x2004_0000),
        (4, 0x2000_00d1),
        (192, u32::from_le_bytes(*b"PDF1")),
        (196, length),
        (200, u32::from(chip)),
        (204, 5),
    ];
    for (at, word) in words {
        bytes[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
    }
    let sum = crc(&bytes).to_le_bytes();
    bytes.extend(sum);
    bytes
}

#[test]
fn a_program_arrives_as_it_was_sent_and_is_given_to_the_runner_once() {
    let mut bench = Bench::in_session(FLASHED);
    let sent = program(1, 700);
    assert_eq!(bench.update(Update::Begin), (UpdateReply::Taken, 0));
    for (n, piece) in (1..).zip(pieces(&sent)) {
        assert_eq!(bench.update(Update::Bytes(piece)), (UpdateReply::Taken, n));
        assert_eq!(bench.received(), Some(n));
    }
    assert_eq!(bench.inbox[..sent.len()], sent);
    assert_eq!(bench.board.port().take_update(), None, "not before it is committed");
    assert_eq!(bench.update(Update::Commit).0, UpdateReply::Taken);
    assert_eq!(bench.state().outcome, UpdateOutcome::Pending);
    assert_eq!(bench.update(Update::Begin).0, UpdateReply::Busy);
    assert_eq!(bench.board.port().take_update(), Some(UpdateOrder::Try { received: bench.inbox.len() }));
    assert_eq!(bench.board.port().take_update(), None);
    assert_eq!(check(&bench.inbox, ChipKind::Rp2040).map(|program| program.length), Ok(700));
    bench.board.port().end_update(UpdateOutcome::Damaged);
    assert_eq!((bench.state().outcome, bench.received()), (UpdateOutcome::Damaged, Some(0)));
}

/// Each of its requests: the host falls silent after it, and the board has forgotten the update
/// when a host comes again.
#[test]
fn a_host_that_stops_after_any_request_leaves_nothing_behind() {
    let sent = program(1, 300);
    let mut requests = std::vec![Update::Begin];
    requests.extend(pieces(&sent).into_iter().map(Update::Bytes));
    let mut bench = Bench::in_session(FLASHED);
    for (n, request) in requests.iter().enumerate() {
        assert_eq!(bench.update(*request).0, UpdateReply::Taken);
        let mut alone = bench.clone();
        alone.pass(600);
        assert_eq!(alone.board.port().take_update(), None);
        alone.session = None;
        assert_eq!((alone.received(), alone.state().outcome), (Some(0), UpdateOutcome::None), "request {n}");
        // The silent host's own next request, late: of a session that is over.
        let late = bench.clone().request(PageEntry::Update(Update::Commit));
        assert_eq!(alone.send(late.encode()), None);
        assert_eq!(alone.update(Update::Commit).0, UpdateReply::NeedsSession);
    }
}

/// The same bytes again, from a wire that delays and repeats, count once.
#[test]
fn a_repeated_request_is_not_obeyed_twice() {
    let mut bench = Bench::in_session(FLASHED);
    bench.update(Update::Begin);
    let request = bench.request(PageEntry::Update(Update::Bytes([1, 2, 3]))).encode();
    assert!(bench.send(request).is_some());
    assert_eq!(bench.send(request), None);
    assert_eq!((bench.received(), bench.inbox.len()), (Some(1), 3));
}

#[test]
fn what_must_not_be_is_refused() {
    let mut bench = Bench::new(None);
    assert_eq!(bench.state(), UpdateState::UNSUPPORTED);
    assert_eq!(bench.update(Update::Begin).0, UpdateReply::Unsupported);
    let mut bench = Bench::new(Some(FLASHED));
    for update in [Update::Begin, Update::Bytes([0; 3]), Update::Commit, Update::Confirm] {
        assert_eq!(bench.update(update).0, UpdateReply::NeedsSession);
    }
    let mut bench = Bench::in_session(FLASHED);
    for update in [Update::Bytes([0; 3]), Update::Commit, Update::Confirm] {
        assert_eq!(bench.update(update).0, UpdateReply::NotBegun);
    }
    // Pressure in a chamber, although all is commanded to vent.
    bench.update(Update::Begin);
    bench.pressure = 200;
    bench.pass(60);
    bench.update(Update::Commit);
    assert_eq!(bench.board.port().take_update(), None);
    assert_eq!(bench.state().outcome, UpdateOutcome::NotVented);
    // And a set point.
    bench.pressure = AIR;
    bench.pass(60);
    bench.update(Update::Begin);
    bench.command(AIR + 1);
    bench.update(Update::Commit);
    assert_eq!(bench.board.port().take_update(), None);
    assert_eq!(bench.state().outcome, UpdateOutcome::NotVented);
}

#[test]
fn more_than_a_board_can_keep_is_refused() {
    let mut bench = Bench::in_session(FLASHED);
    bench.update(Update::Begin);
    for n in 0..INBOX / PIECE {
        assert_eq!(bench.update(Update::Bytes([1; 3])).0, UpdateReply::Taken);
        if n % 100 == 0 {
            bench.command(AIR);
        }
    }
    assert_eq!(bench.update(Update::Bytes([1; 3])), (UpdateReply::TooLong, (INBOX / PIECE) as u32));
    assert_eq!(bench.inbox.len(), INBOX);
}

/// Its place is the one where the next program would go.
#[test]
fn a_program_on_trial_can_be_confirmed_and_not_replaced() {
    let mut bench = Bench::in_session(TRIAL);
    assert_eq!(bench.update(Update::Begin).0, UpdateReply::NotBegun);
    assert_eq!(bench.update(Update::Confirm).0, UpdateReply::Taken);
    assert_eq!(bench.board.port().take_update(), Some(UpdateOrder::Keep));
    assert_eq!(number_in(bench.ask(PageEntry::Program(UpdateEntry::RunningCrc))), Some(5));
}

#[test]
fn a_damaged_or_foreign_program_is_refused() {
    let good = program(1, 700);
    let check = |bytes: &[u8]| check(bytes, ChipKind::Rp2040).map(|program| program.length);
    assert_eq!(check(&good), Ok(700));
    for bit in 0..8 * good.len() {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(check(&bytes).is_err(), "bit {bit}");
    }
    for length in 0..good.len() {
        assert!(check(&good[..length]).is_err(), "{length} bytes");
    }
    assert_eq!(check(&program(2, 700)), Err(UpdateOutcome::OtherChip));
    assert_eq!(check(&good[..703]), Err(UpdateOutcome::Damaged));
    let mut other = good.clone();
    other[192] = b'X';
    assert_eq!(check(&other), Err(UpdateOutcome::NotAProgram));
}
