//! Requests for a line rate and the answers to them: their bytes and numbers, frozen.
//!
//! If a test in this file fails, do not change the test: the change that broke it cannot be made.

use crate::frozen::assert_stands;
use pneudrive_protocol::pages::{
    Change, LineRate, LineRateAnswer, LineRateState, NO_SUCH_ENTRY, PageEntry, RateReturn,
};
use pneudrive_protocol::{Address, Counts, PageRequest, Sequence};

/// CRCs from an independent implementation.
#[rustfmt::skip]
const FROZEN_THREE_MBAUD: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x09, // sequence 9, page 9
    0x28, 0x03, // entry 3
    0x48, 0x00,
    0x5C, 0x00, // CRC = 0xAA57
];

#[rustfmt::skip]
const FROZEN_STATE: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x09, // sequence 9, page 9
    0x4C, 0x00, // entry 0
    0x68, 0x00,
    0x74, 0x00, // CRC = 0xCF5D
];

#[rustfmt::skip]
const FROZEN_STATE_ANSWER: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x48, 0x03, // sequence 9; 3 Mbaud in effect
    0x1C, 0x03, // 3 Mbaud allowed
    0x4C, 0x01, // gone back once
    0x78, 0x02, // because of damage; CRC = 0x1E7E
];

const STATE: LineRateState = LineRateState {
    now: LineRate::ThreeMbaud,
    fastest: LineRate::ThreeMbaud,
    returns: 1,
    last_return: Some(RateReturn::Damage),
};

#[test]
fn requests_and_answers_stand_like_this_on_the_wire() {
    let frozen = [
        (PageEntry::SetLineRate(LineRate::ThreeMbaud), FROZEN_THREE_MBAUD),
        (PageEntry::LineRate, FROZEN_STATE),
    ];
    for (entry, bytes) in frozen {
        assert_stands(entry, bytes);
    }
    let request = PageRequest::new(Address::of_board(2), PageEntry::LineRate, Sequence::new(9));
    assert_eq!(request.answer(Some(STATE.to_entry())).encode(), FROZEN_STATE_ANSWER);
}

#[test]
fn entries_keep_their_numbers_and_words() {
    let numbers = [
        (PageEntry::LineRate, (9, 0)),
        (PageEntry::SetLineRate(LineRate::Compiled), (9, 1)),
        (PageEntry::SetLineRate(LineRate::TwoMbaud), (9, 2)),
        (PageEntry::SetLineRate(LineRate::ThreeMbaud), (9, 3)),
        (PageEntry::Change(Change::Begin), (8, 0)),
    ];
    for (entry, (page, number)) in numbers {
        assert_eq!((entry.numbers(), PageEntry::of_numbers(page, number)), ((page, number), Some(entry)));
    }
    assert_eq!(PageEntry::of_numbers(9, 4), None);
    let words = |entry: [Counts; 4]| entry.map(Counts::get);
    assert_eq!(words(STATE.to_entry()), [3, 3, 1, 2]);
    let answers = [LineRateAnswer::Taken, LineRateAnswer::NeedsSession, LineRateAnswer::TooFast];
    assert_eq!(answers.map(|answer| words(answer.to_entry())[0]), [0, 1, 2]);
    // A board of before line rates.
    assert_eq!(LineRateState::from_entry(NO_SUCH_ENTRY), None);
    assert_eq!(LineRateAnswer::from_entry(NO_SUCH_ENTRY), None);
}
