//! The sensors on the I2C connector, as a board's pages tell of them.

use crate::common::Bench;
use pneudrive_control::{I2cSensors, Micros, Motion};
use pneudrive_protocol::pages::{
    Acceleration, AngularRate, Electronics, Entry, GaugePressure, PageEntry, SensorEntry, SensorPart,
    SensorState, SensorStatus, SensorTimes, SupplyReading, Temperature, Voltage,
};
use pneudrive_protocol::{AnswerDecoder, Echo, Heard, PageRequest, Sequence};

fn ask(bench: &mut Bench, entry: SensorEntry) -> Entry {
    ask_page(bench, PageEntry::Sensor(entry))
}

fn ask_page(bench: &mut Bench, entry: PageEntry) -> Entry {
    let request = PageRequest::new(bench.board.address(), entry, Sequence::new(7));
    let answers = bench.raw_bytes(&request.encode());
    bench.wait_us(150);
    let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
    match answers.concat().into_iter().find_map(|byte| decoder.push(byte)).unwrap() {
        Heard::Answer(words) => words,
        Heard::Other(other) => panic!("{other:?}"),
    }
}

fn status(bench: &mut Bench) -> SensorStatus {
    SensorStatus::from_entry(ask(bench, SensorEntry::Status)).unwrap()
}

fn supply(bench: &mut Bench) -> SupplyReading {
    SupplyReading::from_entry(ask(bench, SensorEntry::Supply)).unwrap()
}

fn acceleration(bench: &mut Bench) -> Acceleration {
    Acceleration::from_entry(ask(bench, SensorEntry::Acceleration)).unwrap()
}

fn rate(bench: &mut Bench) -> AngularRate {
    AngularRate::from_entry(ask(bench, SensorEntry::AngularRate)).unwrap()
}

fn times(bench: &mut Bench) -> SensorTimes {
    SensorTimes::from_entry(ask(bench, SensorEntry::Times)).unwrap()
}

fn sensors(bench: &mut Bench) -> &mut I2cSensors {
    bench.board.port().sensors()
}

#[test]
fn a_board_without_sensors_says_so() {
    let mut bench = Bench::running();
    assert_eq!(status(&mut bench), SensorStatus::NONE);
    assert_eq!(supply(&mut bench), SupplyReading::ABSENT);
    assert_eq!(acceleration(&mut bench), Acceleration::ABSENT);
    assert_eq!(rate(&mut bench), AngularRate::ABSENT);
    let never = SensorTimes { supply_age_ms: 1_023, supply_readings: 0, imu_age_ms: 1_023, imu_readings: 0 };
    assert_eq!(times(&mut bench), never);
}

#[test]
fn a_reading_is_live_for_100_ms_and_then_stale() {
    let mut bench = Bench::running();
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    sensors(&mut bench).imu_found(SensorPart::Bmi323);
    assert_eq!(supply(&mut bench).state, SensorState::Stale, "nothing was read so far");
    assert_eq!(acceleration(&mut bench).state(), SensorState::Stale);

    let read = Micros::new(bench.now_us);
    sensors(&mut bench).supply_read(read, Some(GaugePressure::from_pa(612_340)));
    sensors(&mut bench).imu_read(read, Motion::new([0, 0, 981], [400, 0, -200]));
    bench.wait_us(40_000);
    let reading = supply(&mut bench);
    assert_eq!(reading.live_kpa(), Some(612.34));
    assert!((40..=41).contains(&reading.age_ms), "{reading:?}");
    assert_eq!(acceleration(&mut bench).m_per_s2(), Some([0.0, 0.0, 9.81]));
    assert_eq!(rate(&mut bench).rad_per_s(), Some([1.0, 0.0, -0.5]));
    assert_eq!((times(&mut bench).supply_readings, times(&mut bench).imu_readings), (1, 1));
    let live = status(&mut bench);
    assert_eq!((live.supply_state, live.imu_state), (SensorState::Live, SensorState::Live));

    bench.wait_us(60_000);
    assert_eq!(supply(&mut bench).live_kpa(), None);
    assert_eq!(acceleration(&mut bench).state(), SensorState::Stale);
    assert_eq!(acceleration(&mut bench).m_per_s2(), Some([0.0, 0.0, 9.81]), "its last reading");
    let stale = status(&mut bench);
    assert_eq!((stale.supply_state, stale.imu_state), (SensorState::Stale, SensorState::Stale));
}

#[test]
fn what_is_lost_and_found_again_starts_without_a_reading() {
    let mut bench = Bench::running();
    let read = Micros::new(bench.now_us);
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    sensors(&mut bench).supply_read(read, Some(GaugePressure::from_pa(612_340)));
    sensors(&mut bench).supply_lost();
    let lost = supply(&mut bench);
    assert_eq!(lost, SupplyReading::ABSENT);
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    assert_eq!(supply(&mut bench).state, SensorState::Stale);
    assert_eq!(supply(&mut bench).pressure.pa(), 0);
    assert_eq!(times(&mut bench).supply_readings, 1, "the count goes on");
}

#[test]
fn a_broken_transducer_is_said_to_be_one() {
    let mut bench = Bench::running();
    let read = Micros::new(bench.now_us);
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    sensors(&mut bench).supply_read(read, None);
    assert_eq!(supply(&mut bench).state, SensorState::OutOfRange);
    assert_eq!(status(&mut bench).supply_state, SensorState::OutOfRange);
    bench.wait_us(101_000);
    assert_eq!(supply(&mut bench).state, SensorState::Stale);
}

/// A temperature stays; a voltage is as old as the supply pressure, and does not need one.
#[test]
fn temperature_and_voltage_are_told() {
    let mut bench = Bench::running();
    let told = |bench: &mut Bench| {
        let Electronics { chip_temperature, rail_voltage } =
            Electronics::from_entry(ask_page(bench, PageEntry::Electronics)).unwrap();
        (chip_temperature.map(Temperature::celsius), rail_voltage.map(Voltage::volts))
    };
    assert_eq!(told(&mut bench), (None, None));
    sensors(&mut bench).chip_read(Temperature::from_steps(386));
    assert_eq!(told(&mut bench), (Some(27.2), None));

    let read = Micros::new(bench.now_us);
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    sensors(&mut bench).supply_read(read, None);
    sensors(&mut bench).rail_read(Voltage::from_uv(3_100_000));
    assert_eq!(told(&mut bench), (Some(27.2), Some(3.1)), "too low for its transducer");
    bench.wait_us(101_000);
    assert_eq!(told(&mut bench), (Some(27.2), None), "it is old");

    let read = Micros::new(bench.now_us);
    sensors(&mut bench).supply_read(read, Some(GaugePressure::from_pa(612_340)));
    assert_eq!(told(&mut bench), (Some(27.2), Some(3.1)));
    sensors(&mut bench).supply_lost();
    sensors(&mut bench).supply_found(SensorPart::Ads1115);
    sensors(&mut bench).supply_read(read, Some(GaugePressure::from_pa(612_340)));
    assert_eq!(told(&mut bench), (Some(27.2), None), "of another converter");
}
