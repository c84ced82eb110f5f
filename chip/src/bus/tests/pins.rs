use super::{
    FUNCTION_PWM, FUNCTION_SIO, FUNCTION_UART, IO_BANK0, PADS_BANK0, PWM, SIO, UART0, bus, clocked_bus, read,
    run, select_function, write,
};
use crate::bus::{Edge, Level};
use crate::peripherals::uart::LineErrors;
use crate::ticks::Ticks;

const GPIO_IN: u32 = SIO + 0x04;
const GPIO_OUT_SET: u32 = SIO + 0x14;
const GPIO_OUT_CLR: u32 = SIO + 0x18;
const GPIO_OE_SET: u32 = SIO + 0x24;
const IO_IRQ_BANK0: u32 = 1 << 13;

#[test]
fn a_pin_has_the_level_of_its_driver_or_the_outside_or_its_pull() {
    let mut bus = bus();
    let level = |bus: &crate::bus::Bus| bus.pin_level(5, bus.now);
    assert_eq!(level(&bus), Level::Low, "pulled down after reset");
    write(&mut bus, PADS_BANK0 + 4 + 4 * 5, 0x40);
    assert_eq!(level(&bus), Level::Floating);
    write(&mut bus, PADS_BANK0 + 4 + 4 * 5, 0x48);
    assert_eq!(level(&bus), Level::High, "pulled up");
    bus.set_outside_level(5, Level::Low);
    assert_eq!(level(&bus), Level::Low);
    assert_eq!(read(&mut bus, GPIO_IN) >> 5 & 1, 0);
    select_function(&mut bus, 5, FUNCTION_SIO);
    write(&mut bus, GPIO_OUT_SET, 1 << 5);
    assert_eq!(level(&bus), Level::Low, "not enabled yet");
    write(&mut bus, GPIO_OE_SET, 1 << 5);
    assert_eq!((bus.pin_output(5, bus.now), level(&bus)), (Level::High, Level::High));
    assert_eq!(read(&mut bus, GPIO_IN) >> 5 & 1, 1);
    write(&mut bus, PADS_BANK0 + 4 + 4 * 5, 0xc8);
    assert_eq!(bus.pin_output(5, bus.now), Level::Floating, "output disabled in the pad");
}

#[test]
fn a_pin_with_its_input_disabled_reads_low() {
    let mut bus = bus();
    bus.set_outside_level(3, Level::High);
    assert_eq!(read(&mut bus, GPIO_IN), 1 << 3);
    write(&mut bus, PADS_BANK0 + 4 + 4 * 3, 0);
    assert_eq!(read(&mut bus, GPIO_IN), 0);
}

#[test]
fn overrides_force_and_invert() {
    let mut bus = bus();
    let (invert, force_high) = (1, 3);
    bus.set_outside_level(4, Level::High);
    write(&mut bus, IO_BANK0 + 8 * 4 + 4, FUNCTION_SIO | invert << 16);
    assert_eq!(read(&mut bus, GPIO_IN) >> 4 & 1, 0);
    write(&mut bus, IO_BANK0 + 8 * 6 + 4, FUNCTION_SIO | force_high << 12 | invert << 8);
    assert_eq!(bus.pin_output(6, bus.now), Level::High, "enabled by OEOVER, low inverted by OUTOVER");
}

#[test]
fn edges_of_watched_pins_are_logged_with_their_time() {
    let mut bus = bus();
    select_function(&mut bus, 25, FUNCTION_SIO);
    select_function(&mut bus, 24, FUNCTION_SIO);
    bus.watch_pins(1 << 25 | 1 << 2);
    bus.now = Ticks::new(1000);
    write(&mut bus, GPIO_OE_SET, 1 << 25 | 1 << 24);
    bus.now = Ticks::new(2000);
    write(&mut bus, GPIO_OUT_SET, 1 << 25 | 1 << 24);
    bus.now = Ticks::new(3000);
    write(&mut bus, GPIO_OUT_SET, 1 << 25);
    write(&mut bus, GPIO_OUT_CLR, 1 << 25);
    bus.set_outside_level(2, Level::High);
    let edge = |at, pin, level| Edge { at: Ticks::new(at), pin, level };
    assert_eq!(
        bus.take_edges(),
        [edge(2000, 25, Level::High), edge(3000, 25, Level::Low), edge(3000, 2, Level::High)]
    );
    assert_eq!(bus.take_edges(), []);
}

#[test]
fn edges_of_a_watched_pwm_pin_come_by_themselves() {
    let mut bus = clocked_bus();
    select_function(&mut bus, 6, FUNCTION_PWM);
    let slice = PWM + 3 * 0x14;
    write(&mut bus, slice + 0x10, 3999);
    write(&mut bus, slice + 0x0c, 1000);
    bus.watch_pins(1 << 6);
    let start = bus.now;
    write(&mut bus, slice, 1);
    run(&mut bus, start + Ticks::new(8500));
    let edges: Vec<_> = bus.take_edges().into_iter().map(|e| ((e.at - start).get(), e.level)).collect();
    assert_eq!(
        edges,
        [(1000, Level::Low), (4000, Level::High), (5000, Level::Low), (8000, Level::High)],
        "high from the start: the counter stood below the compare value"
    );
    assert!(bus.is_pwm_pin(6) && !bus.is_pwm_pin(8));
}

#[test]
fn watching_a_running_pwm_pin_logs_nothing_of_the_past() {
    let mut bus = clocked_bus();
    select_function(&mut bus, 6, FUNCTION_PWM);
    let slice = PWM + 3 * 0x14;
    write(&mut bus, slice + 0x10, 3999);
    write(&mut bus, slice + 0x0c, 1000);
    let start = bus.now;
    write(&mut bus, slice, 1);
    run(&mut bus, start + Ticks::new(4_000_500));
    bus.watch_pins(1 << 6);
    run(&mut bus, start + Ticks::new(4_002_000));
    let edges: Vec<_> = bus.take_edges().into_iter().map(|e| ((e.at - start).get(), e.level)).collect();
    assert_eq!(edges, [(4_001_000, Level::Low)]);
}

#[test]
fn a_pin_interrupt_raises_its_line() {
    let mut bus = bus();
    let edge_low_of_9 = 1 << (4 + 2);
    write(&mut bus, IO_BANK0 + 0x104, edge_low_of_9);
    bus.set_outside_level(9, Level::High);
    assert_eq!(bus.interrupt_lines() & IO_IRQ_BANK0, 0);
    bus.set_outside_level(9, Level::Low);
    assert_eq!(bus.interrupt_lines() & IO_IRQ_BANK0, IO_IRQ_BANK0);
    assert_eq!(read(&mut bus, IO_BANK0 + 0x124), edge_low_of_9);
    write(&mut bus, IO_BANK0 + 0xf4, edge_low_of_9);
    assert_eq!(bus.interrupt_lines(), 0);
}

#[test]
fn a_uart_reaches_the_outside_only_through_its_pins() {
    let mut bus = clocked_bus();
    for (offset, value) in [(0x24, 7), (0x28, 52), (0x2c, 0x70), (0x30, 0x301), (0x00, 0x55)] {
        write(&mut bus, UART0 + offset, value);
    }
    let start = bus.now;
    run(&mut bus, start + Ticks::from_micros(20));
    assert_eq!(bus.uarts[0].take_transmitted().count(), 0);
    bus.uarts[0].put_on_wire(bus.now, 1, LineErrors::NONE);
    bus.outside_changed();
    let now = bus.now;
    run(&mut bus, now + Ticks::new(1));
    assert_eq!(read(&mut bus, UART0 + 0x18) >> 4 & 1, 1, "nothing received");

    select_function(&mut bus, 16, FUNCTION_UART);
    select_function(&mut bus, 17, FUNCTION_UART);
    write(&mut bus, UART0, 0xaa);
    assert_eq!(bus.pin_output(16, bus.now), Level::Low, "start bit");
    assert_eq!(bus.pin_output(16, bus.now + Ticks::new(125 + 60)), Level::Low, "bit 0");
    assert_eq!(bus.pin_output(16, bus.now + Ticks::new(250 + 60)), Level::High, "bit 1");
    assert_eq!(bus.pin_output(17, bus.now), Level::Floating);
    assert_eq!(bus.uarts[0].take_transmitted().map(|c| c.byte).collect::<Vec<_>>(), [0xaa]);
    bus.uarts[0].put_on_wire(bus.now, 2, LineErrors::NONE);
    bus.outside_changed();
    let now = bus.now;
    run(&mut bus, now + Ticks::new(1));
    assert_eq!(read(&mut bus, UART0), 2);
}
