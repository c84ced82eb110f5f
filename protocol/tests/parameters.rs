//! Requests for parameters and changes of them: their bytes, numbers and names, frozen.
//!
//! If a test of bytes or numbers in this file fails, do not change the test: the change that broke
//! it cannot be made.

use crate::frozen::assert_stands;
use pneudrive_protocol::pages::{Change, PageEntry, Parameter};

/// CRCs from an independent implementation.
#[rustfmt::skip]
const FROZEN_SET: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x48, 0x0F, // sequence 9, page 15: five times 10,404
    0x6C, 0x09, // entry 9: hold_time
    0x5C, 0x4E, // 78 times 102
    0x68, 0x18, // and 24: 60,000; CRC = 0x6EFA
];

#[rustfmt::skip]
const FROZEN_COMMIT: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x08, // sequence 9, page 8
    0x54, 0x02, // entry 2
    0x44, 0x00,
    0x4C, 0x00, // CRC = 0xD633
];

#[rustfmt::skip]
const FROZEN_VALUE: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x05, // sequence 9, page 5
    0x3C, 0x01, // entry 1: kp
    0x28, 0x00,
    0x20, 0x00, // CRC = 0xBD48
];

#[test]
fn requests_stand_like_this_on_the_wire() {
    let frozen = [
        (PageEntry::Change(Change::Set(Parameter::HoldTime, 60_000)), FROZEN_SET),
        (PageEntry::Change(Change::Commit), FROZEN_COMMIT),
        (PageEntry::Parameter(Parameter::Kp), FROZEN_VALUE),
    ];
    for (entry, bytes) in frozen {
        assert_stands(entry, bytes);
    }
}

/// Flash keeps values by these numbers, too.
#[test]
fn parameters_keep_their_numbers() {
    let names = [
        "address",
        "kp",
        "kd",
        "saturation",
        "filter_previous",
        "loop_period",
        "answer_delay",
        "power_up_vent",
        "command_timeout",
        "hold_time",
        "sensor_min",
        "sensor_max",
        "sensor_margin",
        "fault_after_steps",
        "recover_after_steps",
        "damage_limit",
        "damage_window",
        "rise_needs_two",
        "channels",
        "max_baud",
    ];
    for (number, name) in (0..).zip(names) {
        assert_eq!(Parameter::of_number(number).unwrap().info().name, name);
    }
}
