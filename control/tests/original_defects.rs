//! What the original's board gets wrong, and this one does not. Each test names what was seen
//! there.

use crate::common::{Bench, counts, packet};
use pneudrive_control::{AdcSample, BoardConfig, BoardState};
use pneudrive_protocol::Packet;

/// There: a data word ending in 0xFF before another board's address was taken for address 0xFFFF,
/// so board 0 answered and moved to what was meant for others (511 is 0x01FF).
#[test]
fn a_set_point_of_511_for_another_board_is_not_an_address() {
    let mut bench = Bench::running();
    for _ in 0..1_000 {
        let request = packet(1, [511, 255, 767, 1023]);
        assert_eq!(bench.bytes(&request.encode()), []);
        // The other board answers after 10 us, the host goes on after 10 us: no idle gap anywhere.
        bench.wait_us(10);
        assert_eq!(bench.bytes(&packet(1, [300, 400, 500, 511]).encode()), []);
        bench.wait_us(10);
    }
    assert_eq!(bench.request([102; 4]), Some([102; 4]));
    assert_eq!(bench.board.status().counters.answers, 2);
}

/// There: one stray leading byte lost 100 of 100 answers.
#[test]
fn a_stray_byte_costs_nothing_after_a_gap() {
    for stray in 0..=255 {
        let mut bench = Bench::running();
        bench.bytes(&[stray]);
        bench.wait_us(30);
        assert!(bench.request([200; 4]).is_some(), "after a stray byte {stray}");
    }
}

/// There: the frames after a lost byte stayed out of step.
#[test]
fn a_lost_byte_costs_its_own_request_only() {
    for lost in 0..10 {
        let mut bench = Bench::running();
        let mut bytes = packet(0, [511, 255, 1023, 767]).encode().to_vec();
        bytes.remove(lost);
        assert_eq!(bench.bytes(&bytes), [], "without byte {lost}");
        bench.wait_us(200);
        assert!(bench.request([200; 4]).is_some(), "after losing byte {lost}");
        assert_eq!(bench.board.status().commands, [counts(200); 4]);
    }
}

/// There: the set point was still regulated ten minutes after the host had died.
#[test]
fn a_dead_host_does_not_leave_pressure_in_the_chambers() {
    let mut bench = Bench::running();
    bench.request([500; 4]).unwrap();
    bench.read(500);
    assert_eq!(bench.steps(100), [0; 4], "it regulates");
    assert_eq!(bench.steps(600_000), [-400; 4], "it vents");
    assert_eq!(bench.board.status().state, BoardState::Vent);
}

/// There: the filter truncated and settled up to 5 counts low, so the chamber ended 4 kPa high.
#[test]
fn the_pressure_reported_is_the_pressure_there_is() {
    let mut bench = Bench::running();
    for value in (60..=960).chain((60..=960).rev()).step_by(7) {
        bench.read(value);
        bench.steps(100);
        assert_eq!(bench.request([102; 4]), Some([value; 4]));
    }
}

/// There: a command above 1023 made the board drop all four channels while it answered as if
/// nothing were wrong. Here the request is no request: no answer, so the host sees a loss, and the
/// set points stay.
#[test]
fn a_request_with_an_impossible_value_is_not_answered_and_changes_nothing() {
    let mut bench = Bench::running();
    bench.request([300; 4]).unwrap();
    for word in [1024_u16, 1025, 0x7FFF, 0x8000, 65_520, 0xFFFF] {
        for channel in 0..4 {
            let mut bytes = packet(0, [200; 4]).encode();
            bytes[2 + 2 * channel..4 + 2 * channel].copy_from_slice(&word.to_be_bytes());
            assert_eq!(bench.bytes(&bytes), [], "value {channel} = {word}");
            bench.wait_us(200);
        }
    }
    assert_eq!(bench.board.status().commands, [counts(300); 4]);
    assert!(bench.request([300; 4]).is_some());
}

/// There: the filter started at 0, so the first answers carried a part of the pressure.
#[test]
fn the_first_answer_carries_the_whole_pressure() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    bench.read(511);
    bench.step();
    assert_eq!(bench.request([102; 4]), Some([511; 4]));
}

/// There: values were kept from the last time. Here no pressure is reported before one was
/// measured.
#[test]
fn before_the_first_control_step_there_is_no_answer_but_the_commands_are_kept() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    assert_eq!(bench.request([200; 4]), None);
    assert_eq!(bench.board.status().commands, [counts(200); 4]);
    assert_eq!(bench.board.status().counters.requests, 1);
    assert_eq!(bench.board.status().counters.answers, 0);
}

/// There: an overflow could turn the drive round. The largest errors, gains and changes saturate.
#[test]
fn extreme_gains_and_pressures_saturate_towards_the_right_side() {
    let config = BoardConfig { kp: 1_000, kd: 1_000, filter_previous: 0, ..BoardConfig::default() };
    let mut bench = Bench::new(config, 0);
    bench.steps(2_001);
    bench.read(973);
    bench.request([0; 4]).unwrap();
    assert_eq!(bench.steps(2), [-400; 4]);
    bench.samples = [AdcSample::from(counts(51)); 4];
    bench.request([1023; 4]).unwrap();
    assert_eq!(bench.steps(2), [400; 4]);
}

/// The echo of the board's own answer has the form of a request to it.
#[test]
fn a_board_does_not_answer_its_own_echo() {
    let mut bench = Bench::running();
    for delay_us in 0..=20 {
        let answers = bench.bytes(&packet(0, [300; 4]).encode());
        let Some(answer) = answers.first() else { panic!("no answer") };
        bench.wait_us(delay_us);
        assert_eq!(bench.bytes(&answer.encode()), Vec::<Packet>::new(), "echo after {delay_us} us");
        // The host goes on at once.
        if delay_us < 14 {
            bench.wait_us(14 - delay_us);
        }
    }
    assert_eq!(bench.board.status().commands, [counts(300); 4]);
}
