//! The pages of the sensors on the I2C connector: their bytes, numbers and units, frozen.
//!
//! If a test in this file fails, do not change the test: the change that broke it cannot be made.

use crate::frozen::assert_stands;
use pneudrive_protocol::pages::{
    Acceleration, AngularRate, Entry, GaugePressure, NO_SUCH_ENTRY, PageEntry, SensorEntry, SensorPart,
    SensorState, SensorStatus, SensorTimes, SupplyReading,
};
use pneudrive_protocol::{Address, Counts, PageRequest, Sequence};
use proptest::prelude::*;

/// CRCs from an independent implementation.
#[rustfmt::skip]
const FROZEN_REQUESTS: [[u8; 10]; 5] = [
    // board 2; sequence 9, page 30; entry 0: what is there; CRC = 0xDDCE
    [0xFF, 0xFD, 0x4C, 0x1E, 0x5C, 0x00, 0x38, 0x00, 0x38, 0x00],
    // entry 1: supply pressure; CRC = 0xFEC8
    [0xFF, 0xFD, 0x4C, 0x1E, 0x7C, 0x01, 0x58, 0x00, 0x20, 0x00],
    // entry 2: acceleration; CRC = 0x9BC2
    [0xFF, 0xFD, 0x4C, 0x1E, 0x18, 0x02, 0x78, 0x00, 0x08, 0x00],
    // entry 3: angular rate; CRC = 0xB8C4
    [0xFF, 0xFD, 0x4C, 0x1E, 0x38, 0x03, 0x18, 0x00, 0x10, 0x00],
    // entry 4: times; CRC = 0x51D6
    [0xFF, 0xFD, 0x48, 0x1E, 0x50, 0x04, 0x38, 0x00, 0x58, 0x00],
];

#[rustfmt::skip]
const FROZEN_STATUS: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4D, 0x01, // sequence 9; 256 x live + ADS1115
    0x0E, 0x02, // 256 x stale + BMI323
    0x60, 0x05, // 5 errors
    0x6C, 0x01, // 1 recovery; CRC = 0x8F1B
];

#[rustfmt::skip]
const FROZEN_SUPPLY: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x48, 0x0C, // sequence 9; 12 ms old
    0x70, 0x01, // live
    0x1A, 0x44, // 580 x 1024
    0x40, 0x66, // + 102 = 524,288 + 69,734: 697.34 kPa; CRC = 0x70D0
];

#[rustfmt::skip]
const FROZEN_ACCELERATION: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4A, 0xFF, // sequence 9; live, x = 4095 + 0, its first nine bits 0 1111 1111
    0x23, 0xD8, // its last four 1111; y = 4095 - 981, its first six bits 011000
    0x6D, 0x57, // its last seven 0101010; z = 4095 + 4095, its first three bits 111
    0x57, 0xFE, // its last ten 1111111110; CRC = 0x2375
];

#[rustfmt::skip]
const FROZEN_RATE: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x00, // sequence 9; not live, x = 4095 - 4095
    0x44, 0x1F, // y = 4095 + 0
    0x47, 0xFC, // z = 4095 + 400, its first three bits 100
    0x15, 0x8F, // its last ten 0110001111; CRC = 0xC625
];

#[rustfmt::skip]
const FROZEN_NO_IMU: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x49, 0xFF, // sequence 9; not live, and three times 8191
    0x6F, 0xFF,
    0x43, 0xFF,
    0x5F, 0xFF, // CRC = 0x6E17
];

#[rustfmt::skip]
const FROZEN_TIMES: [u8; 10] = [
    0xFF, 0xFD, // board 2
    0x4C, 0x0C, // sequence 9; supply measured 12 ms ago
    0x59, 0xF4, // for the 500th time
    0x44, 0x03, // IMU read 3 ms ago
    0x4F, 0xFE, // for the 1022nd time; CRC = 0xDA33
];

const STATUS: SensorStatus = SensorStatus {
    supply: SensorPart::Ads1115,
    supply_state: SensorState::Live,
    imu: SensorPart::Bmi323,
    imu_state: SensorState::Stale,
    errors: 5,
    recoveries: 1,
};

const TIMES: SensorTimes =
    SensorTimes { supply_age_ms: 12, supply_readings: 500, imu_age_ms: 3, imu_readings: 1_022 };

fn supply() -> SupplyReading {
    SupplyReading { state: SensorState::Live, age_ms: 12, pressure: GaugePressure::from_pa(697_340) }
}

fn request(entry: SensorEntry) -> PageRequest {
    PageRequest::new(Address::of_board(2), PageEntry::Sensor(entry), Sequence::new(9))
}

#[test]
fn requests_stand_like_this_on_the_wire() {
    for (number, (entry, bytes)) in SensorEntry::ALL.into_iter().zip(FROZEN_REQUESTS).enumerate() {
        assert_stands(PageEntry::Sensor(entry), bytes);
        assert_eq!(PageEntry::Sensor(entry).numbers(), (30, number as u8));
    }
    assert_eq!(PageEntry::of_numbers(30, 5), None);
}

#[test]
fn answers_stand_like_this_on_the_wire() {
    let acceleration = Acceleration::from_steps([0, -981, 4_095], true);
    let rate = AngularRate::from_steps([-4_095, 0, 400], false);
    let frozen = [
        (SensorEntry::Status, STATUS.to_entry(), FROZEN_STATUS),
        (SensorEntry::Supply, supply().to_entry(), FROZEN_SUPPLY),
        (SensorEntry::Acceleration, acceleration.to_entry(), FROZEN_ACCELERATION),
        (SensorEntry::AngularRate, rate.to_entry(), FROZEN_RATE),
        (SensorEntry::Acceleration, Acceleration::ABSENT.to_entry(), FROZEN_NO_IMU),
        (SensorEntry::AngularRate, AngularRate::ABSENT.to_entry(), FROZEN_NO_IMU),
        (SensorEntry::Times, TIMES.to_entry(), FROZEN_TIMES),
    ];
    for (entry, words, bytes) in frozen {
        assert_eq!(request(entry).answer(Some(words)).encode(), bytes, "{entry:?}");
    }
}

#[test]
fn words_mean_these_physical_values() {
    assert_eq!(supply().live_kpa(), Some(697.34));
    assert_eq!(supply().pressure.pa(), 697_340);
    let acceleration = Acceleration::from_steps([0, -981, 4_095], true);
    assert_eq!(acceleration.m_per_s2(), Some([0.0, -9.81, 40.95]));
    assert_eq!(acceleration.state(), SensorState::Live);
    let rate = AngularRate::from_steps([-4_095, 0, 400], false);
    assert_eq!(rate.rad_per_s(), Some([-10.2375, 0.0, 1.0]));
    assert_eq!(rate.state(), SensorState::Stale);
}

#[test]
fn what_is_not_live_has_no_live_value() {
    for state in [SensorState::Absent, SensorState::Stale, SensorState::OutOfRange] {
        assert_eq!(SupplyReading { state, ..supply() }.live_kpa(), None);
    }
    assert_eq!(Acceleration::ABSENT.m_per_s2(), None);
    assert_eq!(AngularRate::ABSENT.state(), SensorState::Absent);
    let reading = SupplyReading::from_entry(SupplyReading::ABSENT.to_entry());
    assert_eq!(reading, Some(SupplyReading::ABSENT));
}

#[test]
fn values_beyond_the_range_become_its_end() {
    for (pa, sent) in [(i32::MAX, 5_242_870), (i32::MIN, -5_242_880), (19, 10), (-1, -10)] {
        assert_eq!(GaugePressure::from_pa(pa).pa(), sent);
    }
    let end = Acceleration::from_steps([i16::MIN, i16::MAX, 0], true);
    assert_eq!(Acceleration::from_entry(end.to_entry()).unwrap().m_per_s2(), Some([-40.95, 40.95, 0.0]));
}

#[test]
fn no_such_entry_is_none_of_them() {
    assert_eq!(SensorStatus::from_entry(NO_SUCH_ENTRY), None);
    assert_eq!(SupplyReading::from_entry(NO_SUCH_ENTRY), None);
    assert_eq!(Acceleration::from_entry(NO_SUCH_ENTRY), None);
    assert_eq!(AngularRate::from_entry(NO_SUCH_ENTRY), None);
    assert_eq!(SensorTimes::from_entry(NO_SUCH_ENTRY), None);
}

#[test]
fn states_and_parts_keep_their_numbers() {
    let parts = [SensorPart::None, SensorPart::Ads1115, SensorPart::Bmi323, SensorPart::Other(254)];
    let states = [SensorState::Absent, SensorState::Live, SensorState::Stale, SensorState::OutOfRange];
    for (part, number) in parts.into_iter().zip([0, 1, 2, 254]) {
        for (high, state) in (0..).zip(states) {
            let status = SensorStatus { imu: part, imu_state: state, ..STATUS };
            assert_eq!(status.to_entry()[1].get(), 256 * high + number);
            assert_eq!(SensorStatus::from_entry(status.to_entry()), Some(status));
        }
    }
}

proptest! {
    #[test]
    fn values_come_back(x in -4_095i16..=4_095, y in -4_095i16..=4_095, z in -4_095i16..=4_095, live: bool, steps in -524_288i32..524_288, age_ms in 0u16..=1_023) {
        let acceleration = Acceleration::from_steps([x, y, z], live);
        prop_assert_eq!(Acceleration::from_entry(acceleration.to_entry()), Some(acceleration));
        let rate = AngularRate::from_steps([x, y, z], live);
        prop_assert_eq!(AngularRate::from_entry(rate.to_entry()), Some(rate));
        let pressure = GaugePressure::from_pa(10 * steps);
        prop_assert_eq!(pressure.pa(), 10 * steps);
        let reading = SupplyReading { state: SensorState::Stale, age_ms, pressure };
        prop_assert_eq!(SupplyReading::from_entry(reading.to_entry()), Some(reading));
    }

    /// No words make a reader panic, and what one accepts is what is sent for it.
    #[test]
    fn any_words_are_an_entry_or_none(words in [0u16..=1023, 0..=1023, 0..=1023, 0..=1023]) {
        let entry: Entry = words.map(Counts::saturating);
        prop_assert!(SensorStatus::from_entry(entry).is_none_or(|it| it.to_entry() == entry));
        prop_assert!(SupplyReading::from_entry(entry).is_none_or(|it| it.to_entry() == entry));
        prop_assert!(Acceleration::from_entry(entry).is_none_or(|it| it.to_entry() == entry));
        prop_assert!(AngularRate::from_entry(entry).is_none_or(|it| it.to_entry() == entry));
        prop_assert!(SensorTimes::from_entry(entry).is_none_or(|it| it.to_entry() == entry));
    }
}
