use super::{ADC, FUNCTION_UART};
use super::{
    CLOCKS, TIMER, UART0, WATCHDOG, XOSC, bus, clocked_bus, read, reports, run, select_function, write,
};
use crate::ticks::Ticks;

#[test]
fn a_cycle_is_a_tick_at_125_mhz_and_19_ticks_and_a_bit_before() {
    let mut slow = bus();
    slow.spend_cycles(13);
    slow.catch_up();
    assert_eq!(slow.now, Ticks::new(250), "13 cycles of 6.5 MHz");
    let mut fast = clocked_bus();
    let before = fast.now;
    fast.spend_cycles(13);
    fast.catch_up();
    assert_eq!(fast.now, before + Ticks::new(13));
}

#[test]
fn cycles_at_133_mhz_add_up_exactly() {
    let mut bus = clocked_bus();
    write(&mut bus, 0x4002_8008, 133);
    let before = bus.now;
    for _ in 0..133_000 {
        bus.spend_cycles(1);
        bus.catch_up();
    }
    assert_eq!(bus.now, before + Ticks::from_millis(1));
}

#[test]
fn stopping_clk_sys_is_reported() {
    let mut bus = clocked_bus();
    write(&mut bus, 0x4002_8004, 0x2d);
    assert_eq!(reports(&bus), ["Write of 0x40028004: ValueNotModelled x1"]);
}

#[test]
fn the_timer_counts_the_ticks_of_the_watchdog() {
    let mut bus = bus();
    assert_eq!(read(&mut bus, TIMER + 0x28), 0);
    // 6.5 MHz / 13 = 500 kHz.
    write(&mut bus, WATCHDOG + 0x2c, 1 << 9 | 13);
    bus.now = Ticks::from_micros(1000);
    assert_eq!(read(&mut bus, TIMER + 0x28), 500);
    write(&mut bus, CLOCKS + 0x30, 2);
    write(&mut bus, WATCHDOG + 0x2c, 1 << 9 | 12);
    bus.now = Ticks::from_micros(2000);
    assert_eq!(read(&mut bus, TIMER + 0x28), 1500);
}

#[test]
fn the_uart_divides_clk_peri() {
    let mut bus = clocked_bus();
    select_function(&mut bus, 0, FUNCTION_UART);
    // clk_peri from the crystal: 12 MHz / 16 / 0.75 = 1 Mbaud.
    write(&mut bus, CLOCKS + 0x48, 1 << 11 | 4 << 5);
    for (offset, value) in [(0x24, 0), (0x28, 48), (0x2c, 0x70), (0x30, 0x101), (0x00, 0x55)] {
        write(&mut bus, UART0 + offset, value);
    }
    let sent: Vec<_> = bus.uarts[0].take_transmitted().collect();
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].end - sent[0].start, Ticks::from_micros(10));
}

#[test]
fn the_adc_runs_from_clk_adc() {
    let mut bus = clocked_bus();
    write(&mut bus, CLOCKS + 0x64, 2 << 8);
    let start = bus.now;
    write(&mut bus, ADC, 0b101);
    run(&mut bus, start + Ticks::from_micros(4) - Ticks::new(1));
    assert_eq!(bus.adc.conversions(0).count, 0, "at 24 MHz a conversion takes 4 us");
    run(&mut bus, start + Ticks::from_micros(4));
    assert_eq!(bus.adc.conversions(0).count, 1);
}

#[test]
fn the_crystal_is_stable_after_its_delay() {
    let mut bus = bus();
    write(&mut bus, XOSC + 0xc, 47 * 128);
    write(&mut bus, XOSC, 0xfab << 12 | 0xaa0);
    let start = bus.now;
    bus.now = start + Ticks::from_millis(128);
    assert_eq!(read(&mut bus, XOSC + 4) >> 31, 0);
    bus.now = start + Ticks::from_millis(129);
    assert_eq!(read(&mut bus, XOSC + 4) >> 31, 1);
}
