//! WATCHDOG against section 4.7 of the datasheet and erratum RP2040-E1.

use super::*;

fn watchdog() -> Watchdog {
    let mut watchdog = Watchdog::default();
    set(&mut watchdog, TICK, TICK_ENABLE | 12, Ticks::ZERO);
    watchdog.set_tick(Rate::hertz(12_000_000, 12), Ticks::ZERO);
    watchdog
}

fn set(watchdog: &mut Watchdog, offset: u32, value: u32, now: Ticks) {
    assert_eq!(watchdog.write(offset, RegisterWrite::plain(value), now), Written::Done);
}

#[test]
fn it_fires_after_half_the_loaded_count_of_microseconds() {
    let mut watchdog = watchdog();
    set(&mut watchdog, LOAD, 2 * 50_000, Ticks::ZERO);
    assert_eq!(watchdog.next_event(), Ticks::NEVER, "not enabled");
    let start = Ticks::from_millis(1);
    set(&mut watchdog, CTRL, ENABLE, start);
    assert_eq!(watchdog.next_event(), start + Ticks::from_millis(50));
    assert_eq!(watchdog.read(CTRL, start + Ticks::from_micros(10)), Some(ENABLE | 99_980));
    watchdog.advance(start + Ticks::from_millis(50));
    assert_eq!(watchdog.take_reset(), Some(ResetReason::WatchdogTimer));
    assert_eq!(watchdog.take_reset(), None);
}

#[test]
fn loading_again_puts_it_off() {
    let mut watchdog = watchdog();
    set(&mut watchdog, LOAD, 2000, Ticks::ZERO);
    set(&mut watchdog, CTRL, ENABLE, Ticks::ZERO);
    set(&mut watchdog, LOAD, 2000, Ticks::from_micros(999));
    watchdog.advance(Ticks::from_micros(1000));
    assert_eq!(watchdog.take_reset(), None);
    assert_eq!(watchdog.next_event(), Ticks::from_micros(1999));
}

#[test]
fn a_trigger_fires_at_once() {
    let mut watchdog = watchdog();
    set(&mut watchdog, CTRL, TRIGGER, Ticks::ZERO);
    assert_eq!(watchdog.take_reset(), Some(ResetReason::WatchdogForce));
}

#[test]
fn reason_and_scratch_survive_the_reset_and_the_rest_does_not() {
    let mut watchdog = watchdog();
    set(&mut watchdog, SCRATCH0 + 4 * 3, 0xcafe_f00d, Ticks::ZERO);
    set(&mut watchdog, CTRL, ENABLE, Ticks::ZERO);
    watchdog.restart_after(ResetReason::WatchdogTimer);
    assert_eq!(watchdog.read(REASON, Ticks::ZERO), Some(REASON_TIMER));
    assert_eq!(watchdog.read(SCRATCH0 + 4 * 3, Ticks::ZERO), Some(0xcafe_f00d));
    assert_eq!(watchdog.read(CTRL, Ticks::ZERO), Some(PAUSE_BITS));
    assert_eq!(watchdog.read(TICK, Ticks::ZERO), Some(TICK_ENABLE));
    watchdog.restart_after(ResetReason::WatchdogForce);
    assert_eq!(watchdog.read(REASON, Ticks::ZERO), Some(REASON_FORCE));
}

#[test]
fn without_the_tick_it_stands_still() {
    let mut watchdog = watchdog();
    set(&mut watchdog, LOAD, 10, Ticks::ZERO);
    set(&mut watchdog, CTRL, ENABLE, Ticks::ZERO);
    set(&mut watchdog, TICK, 12, Ticks::from_micros(1));
    assert_eq!(watchdog.tick_cycles(), None);
    watchdog.set_tick(Rate::STOPPED, Ticks::from_micros(1));
    assert_eq!(watchdog.next_event(), Ticks::NEVER);
}
