//! The slices against section 4.5.2 of the datasheet.

use super::*;
use crate::peripherals::Alias;

/// Registers of slice 3.
const SLICE_3: u32 = 3 * SLICE_STRIDE;
const CSR_EN: u32 = 1;
const CSR_PH_CORRECT: u32 = 1 << 1;
const CSR_A_INV: u32 = 1 << 2;

/// A PWM block at 125 MHz, where one count at divider 1 is one tick.
fn pwm() -> Pwm {
    let mut pwm = Pwm::default();
    pwm.set_clock((125_000_000, 1), Ticks::ZERO);
    pwm
}

fn set(pwm: &mut Pwm, offset: u32, value: u32, now: u64) {
    assert_eq!(pwm.write(offset, RegisterWrite::plain(value), Ticks::new(now)), Written::Done);
}

fn get(pwm: &mut Pwm, offset: u32, now: u64) -> u32 {
    pwm.read(offset, Ticks::new(now)).expect("a register")
}

/// Slice 3 with TOP 99 and A at 30, B at 70, started at tick 1000.
fn started(control: u32) -> Pwm {
    let mut pwm = pwm();
    set(&mut pwm, SLICE_3 + TOP, 99, 0);
    set(&mut pwm, SLICE_3 + CC, 70 << 16 | 30, 0);
    set(&mut pwm, SLICE_3 + CSR, control, 1000);
    pwm
}

/// The ticks, from 1000 on, at which channel A of slice 3 is high.
fn high_ticks(pwm: &Pwm, ticks: std::ops::Range<u64>) -> Vec<u64> {
    ticks.filter(|t| pwm.slice_of(6).0.output(false, Ticks::new(1000 + t))).collect()
}

#[test]
fn pins_6_and_7_and_22_belong_to_slice_3() {
    let pwm = started(CSR_EN);
    assert_eq!(pwm.slice_of(6).0.written_top(), 99);
    assert_eq!(pwm.slice_of(22).0.written_top(), 99);
    assert!(!pwm.slice_of(6).1 && pwm.slice_of(7).1);
    assert_eq!(pwm.slice_of(8).0.written_top(), 0xffff);
}

#[test]
fn the_output_is_high_while_the_counter_is_below_the_compare_value() {
    let mut pwm = started(CSR_EN);
    assert_eq!(high_ticks(&pwm, 0..100), (0..30).collect::<Vec<_>>());
    assert_eq!(high_ticks(&pwm, 100..200), (100..130).collect::<Vec<_>>());
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1099), 99);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1100), 0);
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(1000)), 0.3);
    assert_eq!(pwm.slice_of(7).0.duty(true, Ticks::new(1000)), 0.7);
    assert_eq!(pwm.slice_of(6).0.period_ticks(), Ticks::new(100));
}

#[test]
fn compare_values_beyond_the_ends_give_always_low_and_always_high() {
    let mut pwm = pwm();
    set(&mut pwm, SLICE_3 + TOP, 99, 0);
    set(&mut pwm, SLICE_3 + CC, 100 << 16, 0);
    set(&mut pwm, SLICE_3 + CSR, CSR_EN, 0);
    let slice = pwm.slice_of(6).0;
    assert!((0..300).all(|t| !slice.output(false, Ticks::new(t)) && slice.output(true, Ticks::new(t))));
    assert_eq!((slice.duty(false, Ticks::ZERO), slice.duty(true, Ticks::ZERO)), (0.0, 1.0));
}

#[test]
fn inversion_turns_level_and_duty_round() {
    let pwm = started(CSR_EN | CSR_A_INV);
    assert_eq!(high_ticks(&pwm, 0..100), (30..100).collect::<Vec<_>>());
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(1000)), 0.7);
}

#[test]
fn phase_correct_mode_counts_up_and_down_in_twice_the_time() {
    let mut pwm = started(CSR_EN | CSR_PH_CORRECT);
    let expected: Vec<u64> = (0..30).chain(170..200).collect();
    assert_eq!(high_ticks(&pwm, 0..200), expected);
    for (t, counter) in [(0, 0), (99, 99), (100, 99), (101, 98), (199, 0), (200, 0), (201, 1)] {
        assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1000 + t), counter, "at {t}");
    }
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(1000)), 0.3);
    assert_eq!(pwm.slice_of(6).0.period_ticks(), Ticks::new(200));
}

#[test]
fn new_values_take_effect_at_the_wrap() {
    let mut pwm = started(CSR_EN);
    set(&mut pwm, SLICE_3 + CC, 60, 1050);
    set(&mut pwm, SLICE_3 + TOP, 199, 1050);
    assert_eq!(get(&mut pwm, SLICE_3 + CC, 1051), 60, "reads back as written");
    assert_eq!(pwm.next_event(), Ticks::new(1100));
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(1051)), 0.3);
    pwm.advance(Ticks::new(1100));
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(1100)), 0.3, "60 of 200");
    assert_eq!(high_ticks(&pwm, 100..300), (100..160).collect::<Vec<_>>());
    assert_eq!(pwm.next_event(), Ticks::NEVER, "nobody waits for wraps any more");
}

#[test]
fn a_late_look_takes_the_values_over_at_the_wrap_all_the_same() {
    let mut pwm = started(CSR_EN);
    set(&mut pwm, SLICE_3 + TOP, 149, 1050);
    pwm.advance(Ticks::new(1270));
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1270), 20, "wrapped at 1100 and, 150 later, at 1250");
}

#[test]
fn the_divider_is_8_4_fixed_point() {
    let mut pwm = started(0);
    set(&mut pwm, SLICE_3 + DIV, 2 << 4 | 8, 1000);
    set(&mut pwm, SLICE_3 + CSR, CSR_EN, 1000);
    assert_eq!(pwm.slice_of(6).0.period_ticks(), Ticks::new(250), "100 counts of 2.5 ticks");
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1000 + 24), 9);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1000 + 25), 10);
    set(&mut pwm, SLICE_3 + DIV, 0, 1025);
    assert_eq!(pwm.slice_of(6).0.period_ticks(), Ticks::new(25_600), "0 divides by 256");
}

#[test]
fn every_wrap_interrupts_and_is_latched_even_if_nobody_looks() {
    let mut pwm = started(CSR_EN);
    assert_eq!(get(&mut pwm, INTR, 1099), 0);
    assert_eq!(get(&mut pwm, INTR, 1100), 1 << 3);
    set(&mut pwm, INTR, 1 << 3, 1100);
    assert_eq!(get(&mut pwm, INTR, 1101), 0);
    set(&mut pwm, INTE, 1 << 3, 1101);
    assert!(!pwm.interrupt());
    assert_eq!(pwm.next_event(), Ticks::new(1200));
    pwm.advance(Ticks::new(1200));
    assert!(pwm.interrupt());
    assert_eq!(pwm.next_event(), Ticks::new(1300));
}

#[test]
fn watched_pins_announce_every_edge() {
    let mut pwm = started(CSR_EN);
    pwm.watch_pins(1 << 6 | 1 << 7, Ticks::new(1000));
    let mut edges = Vec::new();
    for _ in 0..6 {
        let at = pwm.next_event();
        pwm.advance(at);
        edges.push(at.get());
    }
    assert_eq!(edges, [1030, 1070, 1100, 1130, 1170, 1200]);
}

#[test]
fn watched_pins_in_phase_correct_mode_announce_both_edges() {
    let mut pwm = started(CSR_EN | CSR_PH_CORRECT);
    pwm.watch_pins(1 << 6, Ticks::new(1000));
    let mut edges = Vec::new();
    for _ in 0..6 {
        let at = pwm.next_event();
        pwm.advance(at);
        edges.push(at.get());
    }
    assert_eq!(
        edges,
        [1030, 1070, 1130, 1170, 1200, 1230],
        "A falls, B falls, B rises, A rises, wrap, A falls"
    );
}

#[test]
fn watching_and_pacing_begin_now_and_not_in_the_past() {
    let mut pwm = started(CSR_EN);
    pwm.watch_pins(1 << 6, Ticks::new(5040));
    assert_eq!(pwm.next_event(), Ticks::new(5070));
    let mut pwm = started(CSR_EN);
    pwm.set_pacing(1 << 3, Ticks::new(5040));
    assert_eq!(pwm.take_wraps(), 0);
    assert_eq!(pwm.next_event(), Ticks::new(5100));
    pwm.advance(Ticks::new(5100));
    assert_eq!(pwm.take_wraps(), 1 << 3);
}

#[test]
fn the_common_enable_starts_slices_together_and_stops_them_where_they_are() {
    let mut pwm = started(0);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 5000), 0);
    set(&mut pwm, EN, 1 << 3 | 1 << 4, 5000);
    assert_eq!(get(&mut pwm, EN, 5000), 1 << 3 | 1 << 4);
    let clear = RegisterWrite { raw: 1 << 3, alias: Alias::Clear };
    assert_eq!(pwm.write(EN, clear, Ticks::new(5020)), Written::Done);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 9999), 20);
    assert_eq!(pwm.slice_of(6).0.duty(false, Ticks::new(9999)), 1.0, "stands still below the compare value");
    assert_eq!(get(&mut pwm, 4 * SLICE_STRIDE + CTR, 5030), 30);
}

#[test]
fn a_standing_slice_takes_values_at_once() {
    let mut pwm = pwm();
    set(&mut pwm, SLICE_3 + TOP, 9, 0);
    set(&mut pwm, SLICE_3 + CSR, CSR_EN, 0);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 25), 5);
}

#[test]
fn a_reset_stops_everything() {
    let mut pwm = started(CSR_EN);
    set(&mut pwm, INTE, 1 << 3, 1000);
    pwm.reset();
    assert_eq!(get(&mut pwm, SLICE_3 + CSR, 2000), 0);
    assert_eq!(pwm.next_event(), Ticks::NEVER);
}

#[test]
fn counting_edges_of_the_b_pin_is_refused() {
    let mut pwm = pwm();
    let write = RegisterWrite::plain(CSR_EN | 2 << 4);
    assert_eq!(pwm.write(SLICE_3 + CSR, write, Ticks::ZERO), Written::ValueNotModelled);
    assert_eq!(get(&mut pwm, SLICE_3 + CTR, 1000), 0);
}
