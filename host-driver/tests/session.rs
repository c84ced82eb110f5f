//! Sessions: asked for, kept over losses, taken up again after a board's reset, and never shared.
//! In virtual time.

use crate::support::counts;
use crate::support::pty::PtyBoards;
use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use pneudrive_host::bus::{BoardFormat, Bus, BusOptions, EchoMode, ExchangeError, PageError};
use pneudrive_host::line::{Line, SerialOptions, SerialPort};
use pneudrive_protocol::pages::{PageEntry, SessionOffer};
use pneudrive_protocol::{Address, Asked, Echo, PacketFormat, RequestDecoder};
use std::sync::{Arc, Mutex};

/// A board that knows sessions.
struct Board {
    ear: RequestDecoder,
    next_session: u32,
    /// Numbers of the requests it obeyed in a session; `None` for those outside one.
    obeyed: Vec<Option<u32>>,
}

impl Board {
    fn new() -> Self {
        Self { ear: RequestDecoder::new(Address::of_board(0)), next_session: 1_000, obeyed: Vec::new() }
    }

    fn answer(&mut self, request: &[u8]) -> Vec<u8> {
        let heard = request.iter().filter_map(|&byte| self.ear.push(byte)).last();
        self.ear.line_idle();
        match heard {
            None => Vec::new(),
            Some(Asked::Page(request)) => {
                let entry = request.entry().and_then(|entry| match entry {
                    PageEntry::Session(_) => {
                        self.next_session += 1;
                        let number = self.next_session;
                        let given = self.ear.offer(number);
                        Some(if given { SessionOffer::Number(number) } else { SessionOffer::Busy }.to_entry())
                    }
                    _ => None,
                });
                request.answer(entry).encode().to_vec()
            }
            Some(Asked::Pressures(request)) => {
                self.obeyed.push(match request.format {
                    PacketFormat::Sealed(seal) => Some(seal.number().get()),
                    PacketFormat::Unchecked | PacketFormat::Checked(_) => None,
                });
                request.answer(self.ear.address(), counts(7)).to_vec()
            }
        }
    }
}

type Shared = Arc<Mutex<Board>>;

/// A host on a line on which the requests and answers with these numbers, counted from 0, are lost.
fn host(board: &Shared, lost_requests: &'static [usize], lost_answers: &'static [usize]) -> Bus<VirtualLine> {
    let board = Arc::clone(board);
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).sessions(true);
    let line = VirtualLine::new(move |number, request: &[u8]| -> Reply {
        if lost_requests.contains(&number) {
            return Vec::new();
        }
        let answer = board.lock().unwrap().answer(request);
        if lost_answers.contains(&number) { Vec::new() } else { vec![(AT_ONCE, answer)] }
    });
    Bus::new(line, options).unwrap()
}

fn board() -> Shared {
    Arc::new(Mutex::new(Board::new()))
}

fn obeyed(board: &Shared) -> Vec<Option<u32>> {
    board.lock().unwrap().obeyed.clone()
}

#[test]
fn a_board_that_knows_sessions_is_in_one_after_its_ping() {
    let board = board();
    let mut bus = host(&board, &[], &[]);
    bus.ping(0).unwrap();
    assert!(bus.in_session(0) && bus.format(0) == BoardFormat::Checked);
    (0..20).for_each(|_| assert!(bus.exchange(0, counts(300)).is_ok()));
    assert!(bus.in_session(0));
    let expected: Vec<_> = [None].into_iter().chain((1..=20).map(Some)).collect();
    assert_eq!(obeyed(&board), expected);
    assert_eq!((bus.counters(0).asked, bus.counters(0).lost()), (21, 0));
}

/// Requests 0 ping, 1 session, 2.. commands. Whether a request or its answer was lost, the next one
/// has another number. A session begins with a command; a page asked for before that is none of it,
/// and is not lost.
#[test]
fn a_page_may_be_asked_for_before_the_first_command() {
    let shared = board();
    let mut bus = host(&shared, &[], &[]);
    bus.ping(0).unwrap();
    let error = bus.about(0).unwrap_err();
    assert!(
        matches!(error, PageError::NoSuchEntry { .. }),
        "answered, by a board that has only sessions: {error}"
    );
    assert!(bus.in_session(0));
    bus.exchange(0, counts(200)).unwrap();
    assert!(matches!(bus.about(0), Err(PageError::NoSuchEntry { .. })));
    assert_eq!(obeyed(&shared).last(), Some(&Some(1)));
}

#[test]
fn what_is_lost_is_not_repeated() {
    for (requests, answers) in [(&[4_usize, 7, 8][..], &[][..]), (&[][..], &[4, 7, 8][..])] {
        let board = board();
        let mut bus = host(&board, requests, answers);
        bus.ping(0).unwrap();
        let lost = (0..30).filter(|_| bus.exchange(0, counts(300)).is_err()).count();
        assert_eq!(lost, 3);
        let mut numbers: Vec<_> = obeyed(&board).into_iter().flatten().collect();
        assert_eq!(numbers.last(), Some(&30));
        numbers.dedup();
        assert_eq!(numbers.len(), 30 - requests.len(), "each once");
    }
}

#[test]
fn after_a_reset_the_board_gives_another_session() {
    let board = board();
    let mut bus = host(&board, &[], &[]);
    bus.ping(0).unwrap();
    (0..5).for_each(|_| assert!(bus.exchange(0, counts(300)).is_ok()));
    board.lock().unwrap().ear = RequestDecoder::new(Address::of_board(0));
    let lost = (0..5).filter(|_| bus.exchange(0, counts(300)).is_err()).count();
    assert_eq!(lost, 2, "then it is asked whether it still has the session");
    assert_eq!(obeyed(&board)[6..], [Some(1), Some(2), Some(3)]);
}

/// The second host is a host like the first one. It is told so, and obeyed in nothing.
#[test]
fn a_second_host_is_refused_until_the_first_one_has_left() {
    let board = board();
    let mut first = host(&board, &[], &[]);
    let mut second = host(&board, &[], &[]);
    second.ping(0).unwrap();
    first.ping(0).unwrap();
    first.exchange(0, counts(300)).unwrap();
    let before = obeyed(&board).len();
    // It has been offered a session that the first one's took the place of: nobody answers, and
    // when the window is used up, it asks for another.
    let errors: Vec<_> = (0..10).map(|_| second.exchange(0, counts(900)).unwrap_err()).collect();
    let refused = |error: &ExchangeError| matches!(error, ExchangeError::InSession { .. });
    assert!(errors[8..].iter().all(refused), "{errors:?}");
    assert_eq!(obeyed(&board).len(), before);
    first.leave(0).unwrap();
    second.exchange(0, counts(900)).unwrap();
    assert!(second.in_session(0));
}

/// A host that is started anew asks with another number, from which the board makes another
/// session.
#[test]
fn the_number_that_a_host_asks_with_is_a_random_one_of_this_run() {
    for (random, expected) in [(0, 0), (101, 101), (102, 0), (u32::MAX, (u32::MAX % 102) as u8)] {
        let asked = Arc::new(Mutex::new(Vec::new()));
        let (noted, board) = (Arc::clone(&asked), board());
        let mut line = VirtualLine::new(move |_, request: &[u8]| {
            let mut ear = RequestDecoder::new(Address::of_board(0));
            let heard = request.iter().filter_map(|&byte| ear.push(byte)).last();
            if let Some(Asked::Page(page)) = heard
                && let Some(PageEntry::Session(number)) = page.entry()
            {
                noted.lock().unwrap().push(number);
            }
            vec![(AT_ONCE, board.lock().unwrap().answer(request))]
        });
        line.random = random;
        let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent));
        let mut bus = Bus::new(line, options).unwrap();
        bus.ping(0).unwrap();
        assert_eq!(*asked.lock().unwrap(), [expected], "{random}");
    }
}

/// Of the kernel, not of the clock: two programs that are started at the same time after a boot
/// differ.
#[test]
fn a_serial_ports_numbers_are_not_those_of_a_clock() {
    let boards = PtyBoards::start(0);
    let mut port = SerialPort::open(boards.path(), SerialOptions::default()).unwrap();
    let numbers: Vec<u32> = (0..8).map(|_| port.random()).collect();
    // A clock would have gone on by less than a second from one to the next.
    let steps = numbers.windows(2).filter(|pair| pair[1].wrapping_sub(pair[0]) < 1_000_000).count();
    assert!(steps < 4, "{numbers:?}");
}

#[test]
fn a_board_of_before_sessions_is_spoken_to_as_before() {
    let mut ear = RequestDecoder::new(Address::of_board(0));
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).sessions(true);
    let line = VirtualLine::new(move |_, request: &[u8]| {
        let heard = request.iter().filter_map(|&byte| ear.push(byte)).last();
        let bytes = match heard {
            Some(Asked::Pressures(request)) => request.answer(Address::of_board(0), counts(7)).to_vec(),
            Some(Asked::Page(request)) => request.answer(None).encode().to_vec(),
            None => Vec::new(),
        };
        vec![(AT_ONCE, bytes)]
    });
    let mut bus = Bus::new(line, options).unwrap();
    bus.ping(0).unwrap();
    assert!((0..50).all(|_| bus.exchange(0, counts(300)).is_ok()));
    assert_eq!((bus.in_session(0), bus.line().requests.len()), (false, 52));
}
