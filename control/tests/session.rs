//! A board in a session: who is obeyed, how it ends, and what too many damaged requests do.

use crate::common::{Bench, packet};
use pneudrive_control::{BoardConfig, BoardState, Micros};
use pneudrive_protocol::pages::{NowState, PageEntry, SessionOffer, StateNow};
use pneudrive_protocol::{
    AnswerDecoder, CheckedPacket, Direction, Echo, Heard, PageRequest, RequestNumber, Sequence, Session,
};

/// Asks for a session, with this number of the host's.
fn offer(bench: &mut Bench, host: u8) -> SessionOffer {
    let request = PageRequest::new(bench.board.address(), PageEntry::Session(host), Sequence::new(1));
    let answers = bench.raw_bytes(&request.encode());
    bench.wait_us(150);
    let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
    match answers.concat().into_iter().find_map(|byte| decoder.push(byte)) {
        Some(Heard::Answer(words)) => SessionOffer::from_entry(words).unwrap(),
        other => panic!("{other:?}"),
    }
}

fn begin(bench: &mut Bench) -> Session {
    match offer(bench, 0) {
        SessionOffer::Number(number) => Session::new(bench.board.address(), number),
        SessionOffer::Busy => panic!("busy"),
    }
}

fn bytes(session: Session, number: u32, commands: [u16; 4]) -> [u8; 10] {
    let number = RequestNumber::new(number);
    let checked = CheckedPacket { packet: packet(0, commands), sequence: number.sequence() };
    checked.encode_sealed(Direction::Request, session.seal(number))
}

/// Whether the board answers, which it does to what it obeys.
fn obeys(bench: &mut Bench, bytes: [u8; 10]) -> bool {
    let answers = bench.raw_bytes(&bytes).len();
    bench.wait_us(150);
    answers == 1
}

fn commands(bench: &Bench) -> [u16; 4] {
    bench.board.status().commands.map(|command| command.get())
}

#[test]
fn a_repeated_request_is_not_obeyed_and_is_no_sign_of_life() {
    let mut bench = Bench::running();
    let session = begin(&mut bench);
    assert!(obeys(&mut bench, bytes(session, 1, [500; 4])));
    assert!(obeys(&mut bench, bytes(session, 2, [300; 4])));
    for _ in 0..600 {
        assert!(!obeys(&mut bench, bytes(session, 1, [500; 4])));
        bench.step();
    }
    assert_eq!(commands(&bench), [300; 4]);
    // Fifty of them in a second are also more damage than is usual.
    assert_eq!(bench.board.status().state, BoardState::DamageVent);
    assert_eq!(bench.board.status().counters.command_timeouts, 1);
}

#[test]
fn a_session_is_one_hosts_until_it_has_been_silent_for_the_command_timeout() {
    let mut bench = Bench::running();
    let session = begin(&mut bench);
    assert!(matches!(offer(&mut bench, 0), SessionOffer::Number(_)), "until the first command");
    let session = match offer(&mut bench, 0) {
        SessionOffer::Number(number) if Session::new(bench.board.address(), number) != session => {
            Session::new(bench.board.address(), number)
        }
        other => panic!("another one each time: {other:?}"),
    };
    assert!(obeys(&mut bench, bytes(session, 1, [500; 4])));
    assert_eq!(offer(&mut bench, 3), SessionOffer::Busy);
    let plain = CheckedPacket { packet: packet(0, [900; 4]), sequence: Sequence::new(2) };
    assert!(!obeys(&mut bench, plain.encode(Direction::Request)));
    bench.steps(502);
    assert_eq!(bench.board.status().state, BoardState::Hold);
    assert!(!obeys(&mut bench, bytes(session, 2, [500; 4])), "the session is over");
    let next = begin(&mut bench);
    assert!(obeys(&mut bench, bytes(next, 1, [400; 4])));
    assert!(!obeys(&mut bench, bytes(session, 2, [500; 4])));
    assert_eq!(commands(&bench), [400; 4]);
}

#[test]
fn too_many_damaged_requests_vent_until_the_host_leaves() {
    let limit = 5;
    let config = BoardConfig { damage_limit: limit, ..BoardConfig::default() };
    let mut bench = Bench::new(config, 0);
    bench.steps(2_001);
    bench.read(300);
    let session = begin(&mut bench);
    assert!(obeys(&mut bench, bytes(session, 1, [900; 4])));
    assert_eq!(bench.step(), [400; 4], "it fills");
    for damaged in 1..=limit {
        let mut damage = bytes(session, 2, [900; 4]);
        damage[3] ^= 0x40;
        assert!(!obeys(&mut bench, damage));
        assert_eq!(bench.step(), if damaged < limit { [400; 4] } else { [-400; 4] }, "{damaged}");
    }
    for number in 2..700 {
        assert!(obeys(&mut bench, bytes(session, number, [900; 4])), "it answers");
        assert_eq!(bench.step(), [-400; 4], "and stays vented");
    }
    let page = PageRequest::new(bench.board.address(), PageEntry::State, Sequence::new(3));
    let mut decoder = AnswerDecoder::for_page(page, Echo::Absent);
    let said = bench.raw_bytes(&page.encode()).concat().into_iter().find_map(|byte| decoder.push(byte));
    let Some(Heard::Answer(words)) = said else { panic!("{said:?}") };
    assert_eq!(NowState::from_entry(words).unwrap().board, StateNow::DamageVent);
    bench.wait_us(150);
    assert!(obeys(&mut bench, bytes(session, 700, [0; 4])), "the host leaves");
    bench.step();
    assert_eq!(bench.board.status().state, BoardState::Running);
    let session = begin(&mut bench);
    assert!(obeys(&mut bench, bytes(session, 1, [900; 4])));
    assert_eq!(bench.step(), [400; 4]);
}

/// The command timeout is kept while the board is vented for damage: its host is forgotten all the
/// same.
#[test]
fn a_host_that_falls_silent_is_forgotten_by_a_board_vented_for_damage() {
    let mut bench = Bench::new(BoardConfig { damage_limit: 1, ..BoardConfig::default() }, 0);
    bench.steps(2_001);
    let session = begin(&mut bench);
    assert!(obeys(&mut bench, bytes(session, 1, [900; 4])));
    assert!(!obeys(&mut bench, bytes(session, 1, [900; 4])));
    bench.steps(502);
    assert_eq!(bench.board.status().state, BoardState::DamageVent);
    assert!(matches!(offer(&mut bench, 1), SessionOffer::Number(_)));
}

#[test]
fn a_host_that_does_not_check_cannot_trip_it() {
    let mut bench = Bench::new(BoardConfig { damage_limit: 1, ..BoardConfig::default() }, 0);
    bench.steps(2_001);
    let mut damaged = packet(0, [500; 4]).encode();
    damaged[4] |= 0x40;
    for _ in 0..20 {
        assert!(bench.request([500; 4]).is_some());
        assert!(bench.raw_bytes(&damaged).is_empty());
        bench.step();
    }
    assert_eq!(bench.board.status().state, BoardState::Running);
}

#[test]
fn pressure_rises_only_when_two_requests_agree_if_that_is_wanted() {
    let config = BoardConfig { rise_needs_two: true, power_up_vent: Micros::ZERO, ..BoardConfig::default() };
    let mut bench = Bench::new(config, 0);
    bench.step();
    bench.request([500, 102, 102, 102]).unwrap();
    assert_eq!(commands(&bench), [102; 4]);
    bench.request([500, 102, 102, 90]).unwrap();
    assert_eq!(commands(&bench), [500, 102, 102, 90]);
}
