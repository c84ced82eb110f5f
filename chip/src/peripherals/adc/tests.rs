//! The ADC against section 4.9 of the datasheet.

use super::*;

/// 96 cycles of 48 MHz are 2 us.
const CONVERSION: u64 = 250;

fn adc() -> Adc {
    let mut adc = Adc::default();
    adc.set_clock((48_000_000, 1), Ticks::ZERO);
    for channel in 0..4 {
        adc.set_input(channel, 1000 + 100 * channel as u16);
    }
    set(&mut adc, CS, EN, 0);
    adc
}

fn set(adc: &mut Adc, offset: u32, value: u32, now: u64) {
    assert_eq!(adc.write(offset, RegisterWrite::plain(value), Ticks::new(now)), Written::Done);
}

fn get(adc: &mut Adc, offset: u32) -> u32 {
    adc.read(offset).expect("a register")
}

fn select(channel: u32) -> u32 {
    channel << 12
}

#[test]
fn a_single_conversion_takes_96_cycles_and_samples_at_its_start() {
    let mut adc = adc();
    assert_eq!(get(&mut adc, CS) & READY, READY);
    set(&mut adc, CS, EN | START_ONCE | select(2), 1000);
    assert_eq!(get(&mut adc, CS) & (READY | START_ONCE), 0, "START_ONCE reads as zero");
    adc.set_input(2, 4000);
    assert_eq!(adc.next_event(), Ticks::new(1000 + CONVERSION));
    adc.advance(Ticks::new(1000 + CONVERSION - 1));
    assert_eq!(get(&mut adc, CS) & READY, 0);
    adc.advance(Ticks::new(1000 + CONVERSION));
    assert_eq!(get(&mut adc, CS) & READY, READY);
    assert_eq!(get(&mut adc, RESULT), 1200, "the voltage at the start");
    assert_eq!(adc.conversions(2), Conversions { count: 1, last_sampled: Ticks::new(1000) });
    assert_eq!(adc.next_event(), Ticks::NEVER);
}

#[test]
fn free_running_round_robin_fills_the_fifo_in_turn() {
    let mut adc = adc();
    set(&mut adc, FCS, FIFO_EN | DREQ_EN | 4 << 24, 0);
    set(&mut adc, CS, EN | START_MANY | 0b1011 << 16, 0);
    adc.advance(Ticks::new(4 * CONVERSION - 1));
    assert!(!adc.request(), "three of four");
    adc.advance(Ticks::new(4 * CONVERSION));
    assert!(adc.request());
    let entries: Vec<u32> = (0..4).map(|_| get(&mut adc, FIFO)).collect();
    assert_eq!(entries, [1000, 1100, 1300, 1000], "channels 0, 1, 3, 0");
}

#[test]
fn the_divider_paces_from_start_to_start() {
    let mut adc = adc();
    // 48 MHz / (1 + 479) = 100 kHz: every 10 us.
    set(&mut adc, DIV, 479 << 8, 0);
    set(&mut adc, CS, EN | START_MANY, 0);
    for n in 0..1000 {
        adc.advance(Ticks::new(1250 * n + CONVERSION));
        assert_eq!(adc.conversions(0), Conversions { count: n + 1, last_sampled: Ticks::new(1250 * n) });
        assert_eq!(adc.next_event(), Ticks::new(1250 * (n + 1)));
    }
}

#[test]
fn a_fractional_divider_does_not_drift() {
    let mut adc = adc();
    // 1 + 99 + 128/256 = 100.5 cycles.
    set(&mut adc, DIV, 99 << 8 | 128, 0);
    set(&mut adc, CS, EN | START_MANY, 0);
    adc.advance(Ticks::new(Ticks::PER_SECOND + CONVERSION));
    assert_eq!(
        adc.conversions(0).count,
        48_000_000 * 2 / 201 + 1,
        "starts within a second, the first at zero"
    );
}

#[test]
fn a_divider_shorter_than_a_conversion_runs_back_to_back() {
    let mut adc = adc();
    set(&mut adc, DIV, 10 << 8, 0);
    set(&mut adc, CS, EN | START_MANY, 0);
    adc.advance(Ticks::from_millis(1));
    assert_eq!(adc.conversions(0).count, 500);
}

#[test]
fn overflow_and_underflow_are_sticky() {
    let mut adc = adc();
    set(&mut adc, FCS, FIFO_EN, 0);
    set(&mut adc, CS, EN | START_MANY, 0);
    adc.advance(Ticks::new(6 * CONVERSION));
    assert_eq!(get(&mut adc, FCS) & (OVER | 1 << 9 | 0xf << 16), OVER | 1 << 9 | 4 << 16);
    for _ in 0..5 {
        get(&mut adc, FIFO);
    }
    assert_eq!(get(&mut adc, FCS) & (UNDER | 1 << 8), UNDER | 1 << 8);
    set(&mut adc, FCS, FIFO_EN | OVER | UNDER, 2000);
    assert_eq!(get(&mut adc, FCS) & (OVER | UNDER), 0);
}

#[test]
fn the_fifo_can_hold_eight_bits_for_byte_transfers() {
    let mut adc = adc();
    adc.set_input(0, 0xabc);
    set(&mut adc, FCS, FIFO_EN | SHIFT, 0);
    set(&mut adc, CS, EN | START_ONCE, 0);
    adc.advance(Ticks::new(CONVERSION));
    assert_eq!(get(&mut adc, FIFO), 0xab);
}

#[test]
fn the_interrupt_follows_the_threshold() {
    let mut adc = adc();
    set(&mut adc, FCS, FIFO_EN | 2 << 24, 0);
    set(&mut adc, INTE, 1, 0);
    set(&mut adc, CS, EN | START_MANY, 0);
    adc.advance(Ticks::new(CONVERSION));
    assert!(!adc.interrupt());
    adc.advance(Ticks::new(2 * CONVERSION));
    assert!(adc.interrupt());
    assert_eq!(get(&mut adc, INTS), 1);
    get(&mut adc, FIFO);
    assert!(!adc.interrupt());
}

#[test]
fn with_threshold_zero_the_interrupt_is_always_raised_and_dma_is_not() {
    let mut adc = adc();
    set(&mut adc, INTE, 1, 0);
    set(&mut adc, FCS, FIFO_EN | DREQ_EN, 0);
    assert!(adc.interrupt() && !adc.request());
    set(&mut adc, FCS, FIFO_EN | DREQ_EN | 1 << 24, 0);
    assert!(!adc.interrupt() && !adc.request());
}

#[test]
fn stopping_finishes_the_conversion_that_runs() {
    let mut adc = adc();
    set(&mut adc, CS, EN | START_MANY, 0);
    set(&mut adc, CS, EN, 100);
    adc.advance(Ticks::from_millis(1));
    assert_eq!(adc.conversions(0).count, 1);
}

#[test]
fn without_its_clock_nothing_is_converted() {
    let mut adc = adc();
    adc.set_clock((0, 1), Ticks::ZERO);
    set(&mut adc, CS, EN | START_ONCE, 0);
    assert_eq!(adc.next_event(), Ticks::NEVER);
}

#[test]
fn a_conversion_that_fails_says_so_until_the_sticky_flag_is_cleared() {
    let mut adc = adc();
    set(&mut adc, FCS, FIFO_EN | ERR_IN_FIFO, 0);
    adc.set_failing(true);
    set(&mut adc, CS, EN | START_ONCE, 0);
    adc.advance(Ticks::new(CONVERSION));
    assert_eq!(get(&mut adc, CS) & (READY | ERR | ERR_STICKY), READY | ERR | ERR_STICKY);
    assert_eq!((get(&mut adc, RESULT), get(&mut adc, FIFO)), (1000, 1000 | u32::from(ENTRY_ERR)));

    adc.set_failing(false);
    set(&mut adc, CS, EN | START_ONCE, CONVERSION);
    adc.advance(Ticks::new(2 * CONVERSION));
    assert_eq!(get(&mut adc, CS) & (ERR | ERR_STICKY), ERR_STICKY, "the last one was good");
    assert_eq!(get(&mut adc, FIFO), 1000);
    set(&mut adc, CS, EN | ERR_STICKY, 2 * CONVERSION);
    assert_eq!(get(&mut adc, CS) & (ERR | ERR_STICKY), 0);
}

#[test]
fn the_temperature_sensor_measures_while_it_has_power() {
    let mut adc = adc();
    let mut convert = |control, now: u64| {
        set(&mut adc, CS, EN | control | START_ONCE | select(4), now);
        adc.advance(Ticks::new(now + CONVERSION));
        get(&mut adc, RESULT)
    };
    assert_eq!(convert(TS_EN, 1_000), 876, "27 degrees Celsius");
    assert_eq!(convert(0, 2_000), 0);
}
