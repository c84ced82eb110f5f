//! Requests that bring a board a new program: their bytes, frozen.
//!
//! If a test in this file fails, do not change the test: the change that broke it cannot be made.

use crate::frozen::assert_stands;
use pneudrive_protocol::pages::{
    LastTrial, PageEntry, Running, Update, UpdateAnswer, UpdateEntry, UpdateOutcome, UpdateReply, UpdateState,
};

/// CRCs from an independent implementation.
#[rustfmt::skip]
const FROZEN_BYTES: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x48, 0x33, // sequence 9, page 51: eleven times 102^3
    0x0C, 0x5D, // 93 times 102^2
    0x08, 0x4A, // 74 times 102
    0x04, 0x16, // and 22: 0xC0FFEE; CRC = 0x0C41
];

#[rustfmt::skip]
const FROZEN_COMMIT: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x27, // sequence 9, page 39
    0x48, 0x01, // entry 1
    0x2C, 0x00,
    0x74, 0x00, // CRC = 0xC97D
];

#[rustfmt::skip]
const FROZEN_CONFIRM: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x27, // sequence 9, page 39
    0x2C, 0x02, // entry 2
    0x0C, 0x00,
    0x5C, 0x00, // CRC = 0xAC77
];

#[rustfmt::skip]
const FROZEN_STATE: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x26, // sequence 9, page 38
    0x34, 0x00, // entry 0
    0x20, 0x00,
    0x64, 0x00, // CRC = 0xB519
];

#[test]
fn requests_stand_like_this_on_the_wire() {
    let frozen = [
        (PageEntry::Update(Update::Bytes([0xEE, 0xFF, 0xC0])), FROZEN_BYTES),
        (PageEntry::Update(Update::Commit), FROZEN_COMMIT),
        (PageEntry::Update(Update::Confirm), FROZEN_CONFIRM),
        (PageEntry::Program(UpdateEntry::State), FROZEN_STATE),
    ];
    for (entry, bytes) in frozen {
        assert_stands(entry, bytes);
    }
}

/// The boot stage of a board that was flashed long ago meets hosts and programs of today.
#[test]
fn words_keep_their_meaning() {
    let state = UpdateState {
        outcome: UpdateOutcome::OtherChip,
        running: Running::TrialSecond,
        last_trial: LastTrial::NotConfirmed,
        longest_kib: 127,
    };
    assert_eq!(state.to_entry().map(|word| word.get()), [5, 5, 2, 127]);
    let answer = UpdateAnswer { reply: UpdateReply::TooLong, received: 0x1_2345 };
    assert_eq!(answer.to_entry().map(|word| word.get()), [4, 0x48, 0x345, 0]);
}
