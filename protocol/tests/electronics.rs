//! The page of a board's electronics: its bytes, numbers and units, frozen.
//!
//! If a test in this file fails, do not change the test: the change that broke it cannot be made.

use crate::frozen::assert_stands;
use pneudrive_protocol::pages::{Electronics, Entry, NO_SUCH_ENTRY, PageEntry, Temperature, Voltage};
use pneudrive_protocol::{Address, Counts, PageRequest, Sequence};
use proptest::prelude::*;

/// CRCs from an independent implementation.
#[rustfmt::skip]
const FROZEN_REQUEST: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x1F, // sequence 9, page 31
    0x00, 0x00, // entry 0
    0x54, 0x00,
    0x30, 0x00, // CRC = 0x82AC
];

#[rustfmt::skip]
const FROZEN_ANSWER: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x49, 0x82, // sequence 9; 386 steps of 0.2 K above -50: 27.2 degrees Celsius
    0x25, 0xF6, // 502 steps of 10 mV
    0x74, 0x00,
    0x74, 0x00, // CRC = 0x27BD
];

#[rustfmt::skip]
const FROZEN_NONE: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4F, 0xFF, // sequence 9; no temperature
    0x07, 0xFF, // no voltage
    0x14, 0x00,
    0x78, 0x00, // CRC = 0x84BE
];

fn known() -> Electronics {
    Electronics {
        chip_temperature: Some(Temperature::from_steps(386)),
        rail_voltage: Some(Voltage::from_uv(5_020_000)),
    }
}

fn request() -> PageRequest {
    PageRequest::new(Address::of_board(2), PageEntry::Electronics, Sequence::new(9))
}

#[test]
fn request_and_answers_stand_like_this_on_the_wire() {
    assert_stands(PageEntry::Electronics, FROZEN_REQUEST);
    assert_eq!(PageEntry::of_numbers(31, 1), None);
    for (electronics, bytes) in [(known(), FROZEN_ANSWER), (Electronics::NONE, FROZEN_NONE)] {
        assert_eq!(request().answer(Some(electronics.to_entry())).encode(), bytes);
        assert_eq!(Electronics::from_entry(electronics.to_entry()), Some(electronics));
    }
    assert_eq!(Electronics::from_entry(NO_SUCH_ENTRY), None);
}

#[test]
fn words_mean_these_physical_values() {
    let Electronics { chip_temperature, rail_voltage } = known();
    assert_eq!((chip_temperature.unwrap().celsius(), rail_voltage.unwrap().volts()), (27.2, 5.02));
    for (steps, celsius) in [(i32::MIN, -50.0), (0, -50.0), (250, 0.0), (1_022, 154.4), (i32::MAX, 154.4)] {
        assert_eq!(Temperature::from_steps(steps).celsius(), celsius);
    }
    for (uv, volts) in [(i32::MIN, 0.0), (-1, 0.0), (4_994, 0.0), (5_000, 0.01), (i32::MAX, 10.22)] {
        assert_eq!(Voltage::from_uv(uv).volts(), volts);
    }
}

proptest! {
    /// Boards of later may say more in the last two words.
    #[test]
    fn any_words_but_those_of_no_entry_are_one(words in [0u16..=1023, 0..=1023, 0..=1023, 0..=1022]) {
        let [temperature, voltage, ..] = words;
        let entry: Entry = words.map(Counts::saturating);
        let read = Electronics::from_entry(entry).unwrap();
        let [first, second, ..] = read.to_entry();
        prop_assert_eq!([first.get(), second.get()], [temperature, voltage]);
    }
}
