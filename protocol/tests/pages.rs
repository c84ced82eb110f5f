//! Page requests and their answers: their bytes, frozen, and what damage can make of them.
//!
//! If a test of bytes in this file fails, do not change the test: the change that broke it cannot
//! be made.

use pneudrive_protocol::pages::{
    About, ChannelNow, ChipKind, Counter, Drives, NO_SUCH_ENTRY, NowState, PageEntry, StateNow,
};
use pneudrive_protocol::{
    Address, AnswerDecoder, Asked, CheckedPacket, Counts, Direction, Echo, Heard, Packet, PacketFormat,
    PageAnswer, PageRequest, RequestDecoder, Sequence,
};
use proptest::prelude::*;

/// CRCs as in `checked.rs`, from an independent implementation.
#[rustfmt::skip]
const FROZEN_REQUEST: [u8; 10] = [
    0xFF, // address, high byte
    0xFD, // address, low byte: board 2
    0x4C, // 0, sequence 1001, CRC bit 15 = 1
    0x00, // page 0
    0x50, // 0, CRC bits 14 to 10 = 10100
    0x01, // entry 1: drives
    0x58, // 0, CRC bits 9 to 5 = 10110
    0x00,
    0x6C, // 0, CRC bits 4 to 0 = 11011; CRC = 0xD2DB
    0x00,
];

#[rustfmt::skip]
const FROZEN_LAST_REQUEST: [u8; 10] = [
    0xFF, 0xFE, // board 1
    0x18, 0x03, // sequence 3, page 3
    0x78, 0x0C, // entry 12: the last word of the post-mortem
    0x44, 0x00,
    0x34, 0x00, // CRC = 0x7A2D
];

#[rustfmt::skip]
const FROZEN_ANSWER: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4F, // 0, sequence 1001, CRC bit 15 = 1, word 0 high bits 11
    0x90, // word 0: 912, fills fully
    0x0C, // 0, CRC bits 14 to 10 = 00011, word 1 high bits 00
    0x70, // word 1: 112, vents fully
    0x22, // 0, CRC bits 9 to 5 = 01000, word 2 high bits 10
    0x00, // word 2: 512, closed
    0x32, // 0, CRC bits 4 to 0 = 01100, word 3 high bits 10; CRC = 0x8D0C
    0x01, // word 3: 513
];

#[rustfmt::skip]
const FROZEN_NO_SUCH_ENTRY: [u8; 10] = [
    0xFF, 0xFF, // board 0
    0x7F, 0xFF, // sequence 15
    0x47, 0xFF,
    0x47, 0xFF,
    0x0F, 0xFF, // CRC = 0xC623
];

fn request(board: u8, entry: PageEntry, sequence: u8) -> PageRequest {
    PageRequest::new(Address::of_board(board), entry, Sequence::new(sequence))
}

/// What a board hears that is not the board's fault.
fn asked(own: u8, bytes: &[u8]) -> Option<Asked> {
    let mut decoder = RequestDecoder::new(Address::of_board(own));
    bytes.iter().filter_map(|&byte| decoder.push(byte)).last()
}

#[test]
fn requests_stand_like_this_on_the_wire() {
    let drives = request(2, PageEntry::Drives, 9);
    assert_eq!(drives.encode(), FROZEN_REQUEST);
    assert_eq!(asked(2, &FROZEN_REQUEST), Some(Asked::Page(drives)));
    let last_word = request(1, PageEntry::PostMortemWord(12), 3);
    assert_eq!(last_word.encode(), FROZEN_LAST_REQUEST);
    assert_eq!(asked(1, &FROZEN_LAST_REQUEST), Some(Asked::Page(last_word)));
    assert_eq!(asked(1, &FROZEN_REQUEST), None, "of another board");
}

#[test]
fn answers_stand_like_this_on_the_wire() {
    let drives = Drives::new([400, -400, 0, 1]);
    let answer = request(2, PageEntry::Drives, 9).answer(Some(drives.to_entry()));
    assert_eq!(answer.encode(), FROZEN_ANSWER);
    let none = request(0, PageEntry::About, 15).answer(None);
    assert_eq!(none.encode(), FROZEN_NO_SUCH_ENTRY);
    assert_eq!(none.words, NO_SUCH_ENTRY);
}

/// The numbers by which entries are asked for.
#[test]
fn entries_keep_their_numbers() {
    let numbers = [
        (PageEntry::State, (0, 0)),
        (PageEntry::Drives, (0, 1)),
        (PageEntry::Counter(Counter::Requests), (1, 0)),
        (PageEntry::Counter(Counter::Answers), (1, 1)),
        (PageEntry::Counter(Counter::PageRequests), (1, 2)),
        (PageEntry::Counter(Counter::LineErrors), (1, 3)),
        (PageEntry::Counter(Counter::Packets), (1, 4)),
        (PageEntry::Counter(Counter::DiscardedBytes), (1, 5)),
        (PageEntry::Counter(Counter::Steps), (1, 6)),
        (PageEntry::Counter(Counter::LateSteps), (1, 7)),
        (PageEntry::Counter(Counter::LongestIntervalUs), (1, 8)),
        (PageEntry::Counter(Counter::LongestLoopUs), (1, 9)),
        (PageEntry::Counter(Counter::CommandTimeouts), (1, 10)),
        (PageEntry::Counter(Counter::SensorFaults), (1, 11)),
        (PageEntry::Counter(Counter::UptimeS), (1, 12)),
        (PageEntry::Counter(Counter::WatchdogResets), (1, 13)),
        (PageEntry::Counter(Counter::DamagedRequests), (1, 14)),
        (PageEntry::Counter(Counter::UnverifiedPackets), (1, 15)),
        (PageEntry::About, (2, 0)),
        (PageEntry::PostMortemWord(0), (3, 0)),
        (PageEntry::PostMortemWord(12), (3, 12)),
        (PageEntry::Session(0), (4, 0)),
        (PageEntry::Session(101), (4, 101)),
    ];
    for (entry, expected) in numbers {
        assert_eq!((entry.numbers(), PageEntry::of_numbers(expected.0, expected.1)), (expected, Some(entry)));
    }
}

#[test]
fn entries_keep_their_words() {
    let words = |entry: [Counts; 4]| entry.map(Counts::get);
    use ChannelNow::{Disabled, Regulating, SensorAboveRange, SensorBelowRange, Venting};
    let state =
        NowState { board: StateNow::Hold, channels: [Venting, Regulating, SensorAboveRange, Disabled] };
    assert_eq!(words(state.to_entry()), [0b10_001, 0, 3, 4]);
    let faults = NowState { board: StateNow::PowerUpVent, channels: [SensorBelowRange; 4] };
    assert_eq!(words(faults.to_entry()), [2; 4]);
    let about = About { chip: ChipKind::Rp2040, version: [1, 20, 300] };
    assert_eq!(words(about.to_entry()), [1, 1, 20, 300]);
    assert_eq!(words(Drives::new([1000, -1000, 40, -40]).to_entry()), [912, 112, 552, 472]);
}

proptest! {
    #[test]
    fn entries_come_back(state in 0u8..5, channels in [0usize..5, 0..5, 0..5, 0..5], drives in [-400i16..=400, -400..=400, -400..=400, -400..=400], chip in 0u8..=255, version in [0u16..=1023, 0..=1023, 0..=1023]) {
        use ChannelNow::{Disabled, Regulating, SensorAboveRange, SensorBelowRange, Venting};
        let board = [StateNow::PowerUpVent, StateNow::Running, StateNow::Hold, StateNow::Vent, StateNow::DamageVent][usize::from(state)];
        let known = [Regulating, Venting, SensorBelowRange, SensorAboveRange, Disabled];
        let now = NowState { board, channels: channels.map(|channel| known[channel]) };
        prop_assert_eq!(NowState::from_entry(now.to_entry()), Some(now));
        prop_assert_eq!(Drives::from_entry(Drives::new(drives).to_entry()), Some(Drives::new(drives)));
        let chip = match chip { 0 => ChipKind::Native, 1 => ChipKind::Rp2040, 2 => ChipKind::Rp2350, other => ChipKind::Other(other) };
        let about = About { chip, version };
        prop_assert_eq!(About::from_entry(about.to_entry()), Some(about));
    }

    /// No words make a reader panic, and "no such entry" is never an entry.
    #[test]
    fn any_words_are_an_entry_or_none(words in [0u16..=1023, 0..=1023, 0..=1023, 0..=1023]) {
        let entry = words.map(Counts::saturating);
        prop_assert!(NowState::from_entry(entry).is_none_or(|now| now.to_entry() == entry));
        prop_assert!(Drives::from_entry(entry).is_none_or(|drives| drives.to_entry() == entry));
        prop_assert!(About::from_entry(entry).is_none_or(|about| about.to_entry() == entry));
        prop_assert!(NowState::from_entry(NO_SUCH_ENTRY).is_none() && Drives::from_entry(NO_SUCH_ENTRY).is_none());
        prop_assert!(About::from_entry(NO_SUCH_ENTRY).is_none());
    }
}

/// Boards and hosts of before pages, and original boards: none takes a page packet for one of its
/// own.
#[test]
fn who_knows_no_pages_hears_nothing() {
    for bytes in [FROZEN_REQUEST, FROZEN_LAST_REQUEST, FROZEN_ANSWER, FROZEN_NO_SUCH_ENTRY] {
        assert!(CheckedPacket::decode(&bytes, Direction::Request).is_err());
        assert!(CheckedPacket::decode(&bytes, Direction::Answer).is_err());
        assert!(Packet::decode(&bytes).is_err());
    }
}

/// A page request is read, and the host behind it remains unknown: an unchecked request is still
/// obeyed.
#[test]
fn a_page_request_says_nothing_of_who_commands() {
    let mut decoder = RequestDecoder::new(Address::of_board(2));
    assert!(FROZEN_REQUEST.iter().any(|&byte| decoder.push(byte).is_some()));
    let unchecked = Packet { address: Address::of_board(2), values: [Counts::ATMOSPHERE; 4] };
    let heard: Vec<_> = unchecked.encode().into_iter().filter_map(|byte| decoder.push(byte)).collect();
    assert!(matches!(heard[..], [Asked::Pressures(request)] if request.format == PacketFormat::Unchecked));
}

/// The host takes only the answer to this very page request.
#[test]
fn pressures_and_pages_are_not_mistaken_for_each_other() {
    let page = request(2, PageEntry::Drives, 9);
    let words = Drives::new([400, -400, 0, 1]).to_entry();
    let pressures =
        CheckedPacket { packet: Packet { address: page.address, values: words }, sequence: page.sequence };
    let hear = |mut decoder: AnswerDecoder, bytes: [u8; 10]| -> Option<Heard> {
        bytes.into_iter().find_map(|byte| decoder.push(byte))
    };
    let for_page = || AnswerDecoder::for_page(page, Echo::Absent);
    assert_eq!(hear(for_page(), FROZEN_ANSWER), Some(Heard::Answer(words)));
    assert!(matches!(hear(for_page(), pressures.encode(Direction::Answer)), Some(Heard::Other(_))));
    let late = PageAnswer { sequence: Sequence::new(8), ..page.answer(Some(words)) };
    assert!(matches!(hear(for_page(), late.encode()), Some(Heard::Other(_))));
    assert_eq!(hear(for_page(), page.encode()), None, "its own echo");
    let for_pressures = AnswerDecoder::for_checked(pressures, Echo::Absent);
    assert!(matches!(hear(for_pressures, FROZEN_ANSWER), Some(Heard::Other(_))));
}

/// Every pattern of up to four flipped bits is tried: a page request becomes no command, and a page
/// answer no pressures. CRCs are linear, so that what one packet shows holds for all.
#[test]
fn fewer_than_five_flipped_bits_make_no_command_of_a_page_request() {
    let page = request(2, PageEntry::Drives, 9);
    let answer = page.answer(Some(Drives::new([1, 2, 3, 4]).to_entry()));
    for (bytes, direction) in [(page.encode(), Direction::Request), (answer.encode(), Direction::Answer)] {
        assert_eq!(fewest_flips(bytes, direction), 5);
    }
}

/// The smallest number of flipped bits, up to 5, that makes a valid packet of this direction of
/// `bytes`.
fn fewest_flips(bytes: [u8; 10], direction: Direction) -> usize {
    use pneudrive_protocol::CheckedError;
    let syndrome = |bytes: [u8; 10]| match CheckedPacket::decode(&bytes, direction) {
        Ok(_) => Some(0),
        Err(CheckedError::Crc { expected, got }) => Some(expected ^ got),
        Err(CheckedError::Form(_)) => None,
    };
    let start = syndrome(bytes).unwrap();
    let single: Vec<u16> = (8..80)
        .filter_map(|bit| {
            let mut flipped = bytes;
            flipped[bit / 8] ^= 0x80 >> (bit % 8);
            Some(syndrome(flipped)? ^ start)
        })
        .collect();
    assert_eq!(single.len(), 68);
    (1..=5).find(|&flips| reachable(&single, flips, start)).unwrap_or(6)
}

/// Whether so many different ones of `single` add up to `sum`.
fn reachable(single: &[u16], flips: usize, sum: u16) -> bool {
    match flips {
        0 => sum == 0,
        _ => (0..single.len()).any(|n| reachable(&single[n + 1..], flips - 1, sum ^ single[n])),
    }
}
