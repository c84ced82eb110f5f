//! TIMER against section 4.6 of the datasheet.

use super::*;

fn timer() -> Timer {
    let mut timer = Timer::default();
    timer.set_tick(Rate::hertz(1_000_000, 1), Ticks::ZERO);
    timer
}

fn set(timer: &mut Timer, offset: u32, value: u32, now: Ticks) {
    assert_eq!(timer.write(offset, RegisterWrite::plain(value), now), Written::Done);
}

fn get(timer: &mut Timer, offset: u32, now: Ticks) -> u32 {
    timer.read(offset, now).expect("a register")
}

#[test]
fn it_counts_whole_microseconds_from_the_start_of_the_tick() {
    let mut timer = Timer::default();
    assert_eq!(get(&mut timer, TIMERAWL, Ticks::from_micros(100)), 0, "no tick yet");
    timer.set_tick(Rate::hertz(1_000_000, 1), Ticks::from_micros(100));
    assert_eq!(get(&mut timer, TIMERAWL, Ticks::new(100 * 125 + 124)), 0);
    assert_eq!(get(&mut timer, TIMERAWL, Ticks::new(101 * 125)), 1);
}

#[test]
fn reading_the_lower_half_latches_the_upper_one() {
    let mut timer = timer();
    set(&mut timer, TIMELW, 0xffff_fffe, Ticks::ZERO);
    set(&mut timer, TIMEHW, 7, Ticks::ZERO);
    assert_eq!(get(&mut timer, TIMELR, Ticks::from_micros(1)), 0xffff_ffff);
    let later = Ticks::from_micros(5);
    assert_eq!(get(&mut timer, TIMEHR, later), 7, "as it was with the lower half");
    assert_eq!(get(&mut timer, TIMERAWH, later), 8);
    assert_eq!(get(&mut timer, TIMERAWL, later), 3);
}

#[test]
fn an_alarm_fires_once_at_its_microsecond() {
    let mut timer = timer();
    set(&mut timer, INTE, 0b0100, Ticks::ZERO);
    set(&mut timer, ALARM0 + 8, 1000, Ticks::ZERO);
    assert_eq!(get(&mut timer, ARMED, Ticks::ZERO), 0b0100);
    assert_eq!(timer.next_event(), Ticks::from_micros(1000));
    timer.advance(Ticks::from_micros(1000));
    assert_eq!(timer.interrupts(), 0b0100);
    assert_eq!(get(&mut timer, ARMED, Ticks::from_micros(1000)), 0);
    set(&mut timer, INTR, 0b0100, Ticks::from_micros(1001));
    assert_eq!(timer.interrupts(), 0);
    assert_eq!(timer.next_event(), Ticks::NEVER);
}

#[test]
fn an_alarm_in_the_past_waits_for_the_lower_half_to_come_round() {
    let mut timer = timer();
    let now = Ticks::from_micros(500);
    set(&mut timer, ALARM0, 499, now);
    assert_eq!(timer.next_event(), Ticks::from_micros((1 << 32) + 499));
    set(&mut timer, ALARM0, 500, now);
    assert_eq!(timer.next_event(), Ticks::from_micros((1 << 32) + 500));
    set(&mut timer, ALARM0, 501, now);
    assert_eq!(timer.next_event(), Ticks::from_micros(501));
}

#[test]
fn disarming_is_writing_ones_to_armed() {
    let mut timer = timer();
    set(&mut timer, ALARM0, 10, Ticks::ZERO);
    set(&mut timer, ALARM3, 20, Ticks::ZERO);
    set(&mut timer, ARMED, 1, Ticks::ZERO);
    assert_eq!(timer.next_event(), Ticks::from_micros(20));
}

#[test]
fn pause_holds_count_and_alarms() {
    let mut timer = timer();
    set(&mut timer, ALARM0, 100, Ticks::ZERO);
    set(&mut timer, PAUSE, 1, Ticks::from_micros(40));
    assert_eq!(timer.next_event(), Ticks::NEVER);
    assert_eq!(get(&mut timer, TIMERAWL, Ticks::from_micros(90)), 40);
    set(&mut timer, PAUSE, 0, Ticks::from_micros(90));
    assert_eq!(timer.next_event(), Ticks::from_micros(150));
}

#[test]
fn forced_interrupts_need_no_enable() {
    let mut timer = timer();
    set(&mut timer, INTF, 0b1000, Ticks::ZERO);
    assert_eq!(timer.interrupts(), 0b1000);
    assert_eq!(get(&mut timer, INTS, Ticks::ZERO), 0b1000);
    assert_eq!(get(&mut timer, INTR, Ticks::ZERO), 0);
}
