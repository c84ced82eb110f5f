//! What a board does when things go wrong, and how it comes back.

use crate::common;
use crate::common::{Bench, counts, packet};
use pneudrive_control::{
    AdcSample, Board, BoardConfig, BoardState, ChannelStatus, ConfigError, DirPwm, Micros, SensorFault,
    ValveDrive,
};
use pneudrive_protocol::{Address, Counts};

#[test]
fn it_vents_for_two_seconds_after_power_up_and_then_does_what_it_was_told() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    bench.now_us = 130_000 - common::STEP_US;
    assert_eq!(bench.step(), [-400; 4]);
    for _ in 0..1_999 {
        bench.request([500; 4]).unwrap();
        bench.now_us -= 250;
        assert_eq!(bench.step(), [-400; 4]);
        assert_eq!(bench.board.status().channels, [ChannelStatus::Venting; 4]);
    }
    assert_eq!(bench.board.status().state, BoardState::PowerUpVent);
    assert_eq!(bench.step(), [400; 4]);
    assert_eq!(bench.board.status().state, BoardState::Running);
    assert_eq!(bench.board.status().channels, [ChannelStatus::Regulating; 4]);
}

#[test]
fn without_a_host_it_stays_at_atmosphere_and_then_vents() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    bench.steps(2_001);
    assert_eq!(bench.steps(499), [0; 4]);
    assert_eq!(bench.board.status().state, BoardState::Running);
    bench.step();
    assert_eq!(bench.board.status().state, BoardState::Hold);
    bench.steps(2_000);
    assert_eq!(bench.board.status().state, BoardState::Vent);
}

#[test]
fn it_holds_then_vents_when_the_host_falls_silent_and_revives_at_a_request() {
    let mut bench = Bench::running();
    bench.read(500);
    bench.steps(100);
    bench.request([490; 4]).unwrap();
    assert_eq!(bench.steps(499), [-100; 4]);
    assert_eq!(bench.board.status().state, BoardState::Running);
    assert_eq!(bench.step(), [-100; 4], "it holds its set points");
    assert_eq!(bench.board.status().state, BoardState::Hold);
    assert_eq!(bench.steps(1_999), [-100; 4]);
    assert_eq!(bench.step(), [-400; 4], "it vents");
    assert_eq!(bench.board.status().state, BoardState::Vent);

    assert_eq!(bench.request([510; 4]), Some([500; 4]));
    assert_eq!(bench.step(), [100; 4]);
    assert_eq!(bench.board.status().state, BoardState::Running);
    assert_eq!(bench.board.status().counters.command_timeouts, 1);
}

#[test]
fn requests_to_others_and_damaged_ones_do_not_count_as_a_host() {
    let mut bench = Bench::running();
    for _ in 0..3_000 {
        bench.bytes(&packet(1, [300; 4]).encode());
        bench.wait_us(40);
        bench.bytes(&packet(0, [300; 4]).encode()[..9]);
        bench.wait_us(40);
        bench.step();
    }
    assert_eq!(bench.board.status().state, BoardState::Vent);
}

#[test]
fn a_sensor_fault_vents_its_channel_only_and_says_so() {
    for (reading, fault, reported) in [(50, SensorFault::BelowRange, 0), (974, SensorFault::AboveRange, 1023)]
    {
        let mut bench = Bench::running();
        bench.read(500);
        bench.steps(100);
        bench.request([510; 4]).unwrap();
        bench.samples[2] = AdcSample::from(counts(reading));
        // For nine steps it goes on with its last good pressure.
        assert_eq!(bench.steps(9), [100; 4]);
        assert_eq!(bench.request([510; 4]), Some([500; 4]));
        // The tenth makes the fault.
        assert_eq!(bench.step(), [100, 100, -400, 100]);
        assert_eq!(bench.request([510; 4]), Some([500, 500, reported, 500]));
        assert_eq!(bench.board.status().channels[2], ChannelStatus::SensorFault(fault));
        assert_eq!(bench.board.status().channels[1], ChannelStatus::Regulating);
        assert_eq!(bench.board.status().counters.sensor_faults, 1);
    }
}

#[test]
fn a_sensor_is_believed_again_after_a_second_without_fault() {
    let mut bench = Bench::running();
    bench.read(500);
    bench.steps(100);
    bench.samples[0] = AdcSample::from(Counts::MIN);
    bench.steps(10);
    bench.samples[0] = AdcSample::from(counts(480));
    for _ in 0..999 {
        bench.request([500; 4]).unwrap();
        assert_eq!(bench.step()[0], -400);
    }
    // Its filter starts anew, at the first good sample.
    assert_eq!(bench.step(), [200, 0, 0, 0]);
    assert_eq!(bench.request([500; 4]), Some([480, 500, 500, 500]));
}

#[test]
fn a_short_glitch_neither_moves_the_valve_nor_makes_a_fault() {
    let mut bench = Bench::running();
    bench.read(500);
    bench.steps(100);
    bench.request([500; 4]).unwrap();
    for _ in 0..20 {
        bench.read(1023);
        assert_eq!(bench.steps(9), [0; 4]);
        bench.read(500);
        assert_eq!(bench.steps(2), [0; 4]);
    }
    assert_eq!(bench.board.status().counters.sensor_faults, 0);
}

#[test]
fn a_sensor_that_is_broken_from_the_start_is_never_regulated() {
    let mut bench = Bench::new(BoardConfig { power_up_vent: Micros::ZERO, ..BoardConfig::default() }, 0);
    bench.samples[3] = AdcSample::from(Counts::MIN);
    bench.request([500; 4]);
    for _ in 0..50 {
        assert_eq!(bench.step(), [400, 400, 400, -400]);
    }
    assert_eq!(bench.request([500; 4]), Some([102, 102, 102, 0]));
    assert_eq!(bench.board.status().counters.sensor_faults, 1);
}

#[test]
fn every_healthy_pressure_differs_from_what_a_fault_reports() {
    for value in 51..=973 {
        let mut bench = Bench::running();
        bench.read(value);
        bench.steps(100);
        let answered = bench.request([102; 4]).unwrap();
        assert!(answered.iter().all(|&pressure| pressure != 0 && pressure != 1023), "{answered:?}");
    }
}

#[test]
fn a_disabled_channel_vents_and_its_sensor_is_not_judged() {
    let config = BoardConfig { enabled: [true, false, true, true], ..BoardConfig::default() };
    let mut bench = Bench::new(config, 0);
    bench.samples[1] = AdcSample::from(counts(7));
    bench.steps(2_001);
    assert_eq!(bench.request([500; 4]), Some([102, 7, 102, 102]));
    assert_eq!(bench.step(), [400, -400, 400, 400]);
    assert_eq!(bench.board.status().channels[1], ChannelStatus::Disabled);
    assert_eq!(bench.board.status().counters.sensor_faults, 0);
}

#[test]
fn a_limited_drive_still_vents_fully_when_it_must() {
    let mut bench = Bench::new(BoardConfig { saturation: 100, ..BoardConfig::default() }, 0);
    assert_eq!(bench.step(), [-400; 4]);
    bench.steps(2_000);
    bench.request([0; 4]).unwrap();
    assert_eq!(bench.step(), [-100; 4]);
    bench.request([900; 4]).unwrap();
    assert_eq!(bench.step(), [100; 4]);
}

#[test]
fn a_late_step_is_counted() {
    let mut bench = Bench::running();
    bench.steps(10);
    assert_eq!(bench.board.status().counters.late_steps, 0);
    bench.wait_us(501);
    bench.step();
    assert_eq!(bench.board.status().counters.late_steps, 1);
}

#[test]
fn a_board_is_not_made_from_a_bad_parameter() {
    let config = BoardConfig { kp: 0, ..BoardConfig::default() };
    let refused = Board::new(config, Address::of_board(0)).map(|_| ());
    assert_eq!(
        refused,
        Err(ConfigError { parameter: "kp", unit: "drive counts per count", value: 0, min: 1, max: 1_000 })
    );
}

#[test]
fn the_safe_drive_has_both_pins_high() {
    assert_eq!(DirPwm::from(ValveDrive::FULL_VENT), DirPwm::SAFE);
    assert!(DirPwm::SAFE.dir_is_high());
    assert_eq!(DirPwm::SAFE.coil(), -255);
}
