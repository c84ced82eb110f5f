//! Sessions: their bytes, frozen, and what a board obeys.
//!
//! If a test of bytes in this file fails, do not change the test: the change that broke it cannot
//! be made.

use pneudrive_protocol::pages::{Drives, PageEntry, SessionOffer};
use pneudrive_protocol::{
    Address, AnswerDecoder, Asked, CheckedPacket, Counts, Direction, Echo, Heard, Packet, PacketFormat,
    PageRequest, Request, RequestDecoder, RequestNumber, Sequence, Session,
};

const NUMBER: u32 = 0x1234_5678;

/// CRCs from an independent implementation (bit by bit, in Python), as in `checked.rs`.
#[rustfmt::skip]
const FROZEN_FIRST: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x08, 0x66, // sequence 1 (request 1), value 0: 102
    0x24, 0xFF, // value 1: 255
    0x1A, 0x00, // value 2: 512
    0x23, 0xFF, // value 3: 1023; CRC = 0x24C8
];
#[rustfmt::skip]
const FROZEN_FIRST_ANSWER: [u8; 10] =
    [0xFF, 0xFD, 0x08, 0x00, 0x28, 0x01, 0x61, 0xFF, 0x13, 0x9A]; // 0, 1, 511, 922; CRC = 0x2B04
/// Request 16, the first of round 1, to boards 2 and 3.
#[rustfmt::skip]
const FROZEN_ROUND_1: [[u8; 10]; 2] = [
    [0xFF, 0xFD, 0x05, 0x2C, 0x21, 0x2D, 0x75, 0x2E, 0x69, 0x2F], // CRC = 0xA3BA
    [0xFF, 0xFC, 0x01, 0x2C, 0x49, 0x2D, 0x65, 0x2E, 0x11, 0x2F], // CRC = 0x4B24
];
/// Request 524,287, the last before 0: the host leaves.
const FROZEN_LAST: [u8; 10] = [0xFF, 0xFD, 0x7C, 0x00, 0x48, 0x00, 0x0C, 0x00, 0x48, 0x00];
/// Request 2: a page request for the drives, and its answer.
const FROZEN_PAGE: [u8; 10] = [0xFF, 0xFD, 0x10, 0x00, 0x1C, 0x01, 0x64, 0x00, 0x24, 0x00];
const FROZEN_PAGE_ANSWER: [u8; 10] = [0xFF, 0xFD, 0x13, 0x90, 0x40, 0x70, 0x1E, 0x00, 0x7A, 0x01];
/// A host asks for a session with its number 7; the board gives one, or is in one. Sequence 9.
const FROZEN_ASKED: [u8; 10] = [0xFF, 0xFD, 0x48, 0x04, 0x28, 0x07, 0x04, 0x00, 0x78, 0x00];
const FROZEN_OFFER: [u8; 10] = [0xFF, 0xFD, 0x48, 0x00, 0x61, 0x23, 0x19, 0x15, 0x66, 0x78];
const FROZEN_BUSY: [u8; 10] = [0xFF, 0xFD, 0x4C, 0x04, 0x5C, 0x00, 0x64, 0x00, 0x1C, 0x00];

fn address(board: u8) -> Address {
    Address::of_board(board)
}

fn sealed(board: u8, session: u32, number: u32, values: [u16; 4], direction: Direction) -> [u8; 10] {
    let packet = Packet { address: address(board), values: values.map(|value| Counts::new(value).unwrap()) };
    let number = RequestNumber::new(number);
    let seal = Session::new(packet.address, session).seal(number);
    CheckedPacket { packet, sequence: number.sequence() }.encode_sealed(direction, seal)
}

fn request(number: u32) -> [u8; 10] {
    sealed(2, NUMBER, number, [300, 301, 302, 303], Direction::Request)
}

/// A board 2 that has offered this session.
fn board() -> RequestDecoder {
    let mut board = RequestDecoder::new(address(2));
    assert!(board.offer(NUMBER));
    board
}

fn ask(board: &mut RequestDecoder, bytes: [u8; 10]) -> Option<Asked> {
    board.line_idle();
    bytes.into_iter().filter_map(|byte| board.push(byte)).last()
}

fn obeys(board: &mut RequestDecoder, bytes: [u8; 10]) -> Option<Request> {
    ask(board, bytes).and_then(Asked::pressures)
}

#[test]
fn requests_and_answers_stand_like_this_on_the_wire() {
    assert_eq!(sealed(2, NUMBER, 1, [102, 255, 512, 1023], Direction::Request), FROZEN_FIRST);
    assert_eq!(sealed(2, NUMBER, 1, [0, 1, 511, 922], Direction::Answer), FROZEN_FIRST_ANSWER);
    for (board, frozen) in [(2, FROZEN_ROUND_1[0]), (3, FROZEN_ROUND_1[1])] {
        assert_eq!(sealed(board, NUMBER, 16, [300, 301, 302, 303], Direction::Request), frozen);
    }
    assert_eq!(sealed(2, NUMBER, 524_287, [0; 4], Direction::Request), FROZEN_LAST);
    let heard = obeys(&mut board(), FROZEN_FIRST).unwrap();
    let pressures = [0, 1, 511, 922].map(Counts::saturating);
    assert_eq!(heard.answer(address(2), pressures), FROZEN_FIRST_ANSWER);
}

#[test]
fn pages_and_offers_stand_like_this_on_the_wire() {
    let seal = Session::new(address(2), NUMBER).seal(RequestNumber::new(2));
    let page = PageRequest::new(address(2), PageEntry::Drives, Sequence::new(0)).sealed(seal);
    assert_eq!(page.encode(), FROZEN_PAGE);
    let words = Drives::new([400, -400, 0, 1]).to_entry();
    assert_eq!(page.answer(Some(words)).encode(), FROZEN_PAGE_ANSWER);
    let asked = PageRequest::new(address(2), PageEntry::Session(7), Sequence::new(9));
    assert_eq!(asked.encode(), FROZEN_ASKED);
    for (offer, frozen) in [(SessionOffer::Number(NUMBER), FROZEN_OFFER), (SessionOffer::Busy, FROZEN_BUSY)] {
        assert_eq!(asked.answer(Some(offer.to_entry())).encode(), frozen);
        assert_eq!(SessionOffer::from_entry(offer.to_entry()), Some(offer));
    }
    assert_eq!(SessionOffer::from_entry(pneudrive_protocol::pages::NO_SUCH_ENTRY), None);
}

#[test]
fn every_request_is_obeyed_once_in_order_and_with_gaps_of_up_to_seven() {
    let mut board = board();
    for number in [1, 2, 3, 11, 19, 20, 28, 36] {
        assert!(obeys(&mut board, request(number)).is_some(), "request {number}");
        for again in number.saturating_sub(40)..=number {
            assert_eq!(obeys(&mut board, request(again)), None, "request {again} after {number}");
        }
        for too_far in number + 9..number + 40 {
            assert_eq!(obeys(&mut board, request(too_far)), None, "request {too_far} after {number}");
        }
    }
}

/// The whole walk round: each number is obeyed, and after the last comes 0.
#[test]
fn numbers_go_round() {
    let mut board = board();
    for number in (1..RequestNumber::MODULUS + 20).step_by(8) {
        let number = number % RequestNumber::MODULUS;
        assert!(obeys(&mut board, request(number)).is_some(), "request {number}");
        assert_eq!(obeys(&mut board, request(number)), None, "request {number} again");
    }
}

#[test]
fn nobody_else_is_obeyed_in_a_session() {
    let mut board = board();
    let values = [300; 4].map(Counts::saturating);
    let plain = CheckedPacket { packet: Packet { address: address(2), values }, sequence: Sequence::new(2) };
    let others = [
        sealed(2, NUMBER + 1, 2, [300; 4], Direction::Request),
        plain.encode(Direction::Request),
        plain.packet.encode(),
    ];
    // Meant for board 1 in its session of the same number, sent with board 2's address.
    let mut swapped = sealed(1, NUMBER, 2, [300; 4], Direction::Request);
    swapped[1] = 0xFD;
    assert!(obeys(&mut board, request(1)).is_some());
    assert!(others.into_iter().chain([swapped]).all(|bytes| obeys(&mut board, bytes).is_none()));
    assert!(!board.offer(5), "another host is given no session");
    assert!(obeys(&mut board, request(2)).is_some(), "and the session goes on");
    board.forget_host();
    assert_eq!(obeys(&mut board, request(3)), None, "the session has ended");
    assert!(obeys(&mut board, plain.encode(Direction::Request)).is_some());
    assert!(board.offer(5), "a host that checks may go on to a session");
}

/// The address's two low bytes differ, so that the CRC of what `nobody_else_is_obeyed` sends is
/// wrong in any case. Here it is right but for the session: as if a host had written the wrong
/// number into its request.
#[test]
fn a_request_meant_for_another_board_has_that_boards_number_in_its_crc() {
    let mut board = board();
    let seal = Session::new(address(1), NUMBER).seal(RequestNumber::new(1));
    let packet = Packet { address: address(2), values: [Counts::ATMOSPHERE; 4] };
    let swapped =
        CheckedPacket { packet, sequence: Sequence::new(1) }.encode_sealed(Direction::Request, seal);
    assert_eq!(obeys(&mut board, swapped), None);
}

#[test]
fn until_its_first_command_an_offered_session_changes_nothing() {
    let mut board = board();
    let seal = Session::new(address(2), NUMBER).seal(RequestNumber::new(1));
    let page = PageRequest::new(address(2), PageEntry::State, Sequence::new(1));
    assert_eq!(ask(&mut board, page.sealed(seal).encode()), None, "a session begins with a command");
    let packet = Packet { address: address(2), values: [Counts::ATMOSPHERE; 4] };
    assert!(matches!(
        obeys(&mut board, packet.encode()),
        Some(Request { format: PacketFormat::Unchecked, .. })
    ));
    assert!(board.offer(NUMBER), "the offer was lost: it is asked for again");
    assert!(obeys(&mut board, request(1)).is_some());
    assert!(matches!(ask(&mut board, page.encode()), Some(Asked::Page(_))), "anybody may ask for pages");
}

#[test]
fn a_host_that_leaves_ends_its_session() {
    let mut board = board();
    assert!(obeys(&mut board, request(1)).is_some());
    let leave = sealed(2, NUMBER, 2, [0; 4], Direction::Request);
    assert!(obeys(&mut board, leave).is_some() && !board.in_session());
    assert_eq!(obeys(&mut board, request(3)), None);
}

#[test]
fn damaged_requests_are_counted_and_those_to_others_are_not() {
    let mut board = board();
    let mut damaged = request(1);
    damaged[5] ^= 4;
    ask(&mut board, damaged);
    assert_eq!(board.damaged_requests(), 0, "a host that does not check may have meant anything");
    ask(&mut board, request(1));
    for bytes in [damaged, request(1), sealed(2, 9, 2, [300; 4], Direction::Request)] {
        ask(&mut board, bytes);
    }
    ask(&mut board, sealed(1, NUMBER, 2, [300; 4], Direction::Request));
    board.line_idle();
    assert_eq!(board.damaged_requests(), 3);
    let statistics = board.statistics();
    assert_eq!((statistics.packets, statistics.discarded_bytes, statistics.unverified), (1, 0, 5));
}

/// Board 1 knows nothing of board 2's session, whose packets follow each other without a gap.
#[test]
fn others_sessions_do_not_cost_a_board_its_requests() {
    let mut board = RequestDecoder::new(address(1));
    let own = Packet { address: address(1), values: [Counts::ATMOSPHERE; 4] };
    let mut heard = 0;
    for number in 0..400 {
        // Values that end in 0xFF look like the beginning of an address.
        let values = [255, 511, 767, 1023];
        let others =
            [Direction::Request, Direction::Answer].map(|way| sealed(2, NUMBER, number, values, way));
        let bytes = others.concat().into_iter().chain(own.encode());
        heard += bytes.filter_map(|byte| board.push(byte)).count();
    }
    assert_eq!(heard, 400);
    assert_eq!(board.statistics().discarded_bytes, 0);
    assert_eq!(board.statistics().unverified, 800);
}

#[test]
fn a_host_takes_only_the_answer_with_the_requests_number() {
    let session = Session::new(address(2), NUMBER);
    let packet = Packet { address: address(2), values: [Counts::ATMOSPHERE; 4] };
    let hear = |bytes: [u8; 10]| {
        let number = RequestNumber::new(40);
        let mut decoder =
            AnswerDecoder::for_sealed(packet, session.seal(number), Echo::Absent).in_session(Some(session));
        bytes.into_iter().find_map(|byte| decoder.push(byte))
    };
    let answer = |number| sealed(2, NUMBER, number, [7; 4], Direction::Answer);
    assert_eq!(hear(answer(40)), Some(Heard::Answer([Counts::saturating(7); 4])));
    assert!((25..40).all(|late| matches!(hear(answer(late)), Some(Heard::Other(_)))));
    // Without a session it would be taken for the answer.
    assert_eq!((hear(answer(24)), hear(answer(40 + 16))), (None, None));
    assert_eq!(hear(request(40)), None, "its echo");
    let plain = CheckedPacket { packet, sequence: Sequence::new(8) };
    assert!(matches!(hear(plain.encode(Direction::Answer)), Some(Heard::Other(_))));
}

/// A board cannot verify what another board and its host say in their session, so nothing aligns
/// the next frame; and a CRC that ends in 0xFF can make the rest of that look like the start of an
/// unchecked packet. Whatever the CRCs, its own requests are heard.
#[test]
fn others_sessions_hide_no_request() {
    let own = Session::new(address(1), 77);
    let mut board = RequestDecoder::new(address(1));
    assert!(board.offer(77));
    let bytes = |session: &Session, board: u8, number: u32, values: [u16; 4], direction: Direction| {
        let packet = Packet { address: address(board), values: values.map(|v| Counts::new(v).unwrap()) };
        let number = RequestNumber::new(number);
        CheckedPacket { packet, sequence: number.sequence() }.encode_sealed(direction, session.seal(number))
    };
    let first = bytes(&own, 1, 1, [102; 4], Direction::Request);
    assert_eq!(first.into_iter().filter_map(|byte| board.push(byte)).count(), 1);
    for number in 2..200_000_u32 {
        let other = Session::new(address(0), number / 1_000);
        // Every value but 0, which is how a host leaves.
        let values: [u16; 4] =
            std::array::from_fn(|k| 1 + (number.wrapping_mul(7 + k as u32) >> 3) as u16 % 1023);
        let line = [
            bytes(&other, 0, number, values, Direction::Request),
            bytes(&other, 0, number, values, Direction::Answer),
            bytes(&own, 1, number, values, Direction::Request),
        ];
        let heard = line.concat().into_iter().filter_map(|byte| board.push(byte)).count();
        assert_eq!(heard, 1, "request {number}");
    }
    assert_eq!(board.damaged_requests(), 0);
}
