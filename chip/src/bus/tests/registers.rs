use super::{
    DMA, IO_BANK0, PADS_BANK0, PWM, RESETS, SIO, TIMER, UART0, WATCHDOG, bus, read, reports, run, write,
};
use crate::bus::Bus;
use crate::peripherals::uart::LineErrors;
use crate::report::ResetReason;
use crate::ticks::Ticks;

const XOR: u32 = 0x1000;
const SET: u32 = 0x2000;
const CLEAR: u32 = 0x3000;

#[test]
fn the_atomic_aliases_change_only_their_bits() {
    let mut bus = bus();
    let pad = PADS_BANK0 + 4 + 4 * 7;
    write(&mut bus, pad, 0b0101_0110);
    write(&mut bus, pad + SET, 0b0000_1001);
    assert_eq!(read(&mut bus, pad), 0b0101_1111);
    write(&mut bus, pad + CLEAR, 0b0001_0001);
    assert_eq!(read(&mut bus, pad), 0b0100_1110);
    write(&mut bus, pad + XOR, 0b0100_0011);
    assert_eq!(read(&mut bus, pad), 0b0000_1101);
    assert_eq!(read(&mut bus, pad + SET), 0b0000_1101, "reads are the same through every alias");
}

#[test]
fn the_aliases_work_behind_ahb_too() {
    let mut bus = bus();
    write(&mut bus, DMA + 0x404, 0b0011);
    write(&mut bus, DMA + 0x404 + SET, 0b0100);
    write(&mut bus, DMA + 0x404 + CLEAR, 0b0001);
    assert_eq!(read(&mut bus, DMA + 0x404), 0b0110);
}

#[test]
fn atomic_writes_to_a_uart_read_first_and_so_take_from_its_fifo() {
    let mut bus = super::clocked_bus();
    super::select_function(&mut bus, 1, super::FUNCTION_UART);
    for (offset, value) in [(0x24, 7), (0x28, 52), (0x2c, 0x70), (0x30, 0x201)] {
        write(&mut bus, UART0 + offset, value);
    }
    write(&mut bus, UART0 + 0x38 + SET, 0x10);
    write(&mut bus, UART0 + 0x38 + SET, 0x40);
    assert_eq!(read(&mut bus, UART0 + 0x38), 0x50);
    for byte in [1, 2] {
        bus.uarts[0].put_on_wire(bus.now, byte, LineErrors::NONE);
    }
    bus.outside_changed();
    bus.advance();
    write(&mut bus, UART0 + SET, 0);
    assert_eq!(read(&mut bus, UART0), 2, "1 was read by the interposer");
}

#[test]
fn taking_the_last_byte_out_of_a_fifo_lowers_its_interrupt_line() {
    let uart0_irq = 1 << 20;
    let mut bus = super::clocked_bus();
    super::select_function(&mut bus, 1, super::FUNCTION_UART);
    // Without FIFOs one byte is enough for the interrupt.
    for (offset, value) in [(0x24, 7), (0x28, 52), (0x2c, 0x60), (0x30, 0x201), (0x38, 0x10)] {
        write(&mut bus, UART0 + offset, value);
    }
    bus.uarts[0].put_on_wire(bus.now, 0x42, LineErrors::NONE);
    bus.outside_changed();
    bus.advance();
    assert_eq!(bus.interrupt_lines(), uart0_irq);
    assert_eq!(bus.take_interrupt_edges(), uart0_irq);
    assert_eq!(read(&mut bus, UART0), 0x42);
    assert_eq!(bus.interrupt_lines(), 0);
    assert_eq!(bus.take_interrupt_edges(), 0);
}

#[test]
fn interrupts_are_acknowledged_by_plain_writes_and_through_the_clear_alias() {
    for alias in [0, CLEAR] {
        let mut bus = bus();
        write(&mut bus, WATCHDOG + 0x2c, 1 << 9 | 6);
        write(&mut bus, TIMER + 0x38, 1);
        write(&mut bus, TIMER + 0x10, 10);
        run(&mut bus, Ticks::from_micros(20));
        assert_eq!(bus.interrupt_lines(), 1);
        write(&mut bus, TIMER + 0x34 + alias, 1);
        assert_eq!(bus.interrupt_lines(), 0);
    }
}

#[test]
fn registers_nobody_models_read_zero_and_are_counted() {
    let mut bus = bus();
    let usb = 0x5011_0000;
    assert_eq!(read(&mut bus, usb + 0x40), 0);
    assert_eq!(read(&mut bus, usb + 0x40), 0);
    write(&mut bus, usb + 0x40 + SET, 1);
    write(&mut bus, SIO + 0x80, 1);
    assert_eq!(
        reports(&bus),
        [
            "Read of 0x50110040: NotModelled x2",
            "Write of 0x50110040: NotModelled x1",
            "Write of 0xd0000080: NotModelled x1"
        ]
    );
}

#[test]
fn a_peripheral_held_in_reset_does_not_answer() {
    let mut bus = Bus::new(Vec::new().into());
    write(&mut bus, UART0 + 0x24, 7);
    assert_eq!(read(&mut bus, UART0 + 0x30), 0);
    assert_eq!(reports(&bus), ["Write of 0x40034024: HeldInReset x1", "Read of 0x40034030: HeldInReset x1"]);
    write(&mut bus, RESETS + CLEAR, 1 << 22);
    assert_eq!(read(&mut bus, UART0 + 0x24), 0);
    assert_eq!(read(&mut bus, UART0 + 0x30), 0x300);
}

#[test]
fn putting_a_peripheral_back_into_reset_loses_its_registers() {
    let mut bus = bus();
    write(&mut bus, PWM + 0x10, 99);
    write(&mut bus, IO_BANK0 + 4, 5);
    write(&mut bus, RESETS + SET, 1 << 14 | 1 << 5);
    write(&mut bus, RESETS + CLEAR, 1 << 14 | 1 << 5);
    assert_eq!(read(&mut bus, PWM + 0x10), 0xffff);
    assert_eq!(read(&mut bus, IO_BANK0 + 4), 0x1f);
    assert_eq!(reports(&bus), [""; 0]);
}

#[test]
fn holding_sio_through_psm_frees_its_spinlocks() {
    let mut bus = bus();
    assert_eq!(read(&mut bus, SIO + 0x17c), 1 << 31);
    assert_eq!(read(&mut bus, SIO + 0x17c), 0);
    write(&mut bus, 0x4001_0004, 1 << 14 | 1 << 16);
    write(&mut bus, 0x4001_0004, 0);
    assert_eq!(read(&mut bus, SIO + 0x17c), 1 << 31);
    assert_eq!(reports(&bus), [""; 0]);
}

#[test]
fn a_watchdog_trigger_is_a_reset_request_with_its_reason() {
    let mut bus = bus();
    write(&mut bus, WATCHDOG, 1 << 31);
    bus.advance();
    assert_eq!(bus.take_reset_request(), Some(ResetReason::WatchdogForce));
    write(&mut bus, 0x4001_0008, 1 << 15);
    assert!(bus.reset_by_watchdog(ResetReason::WatchdogForce), "PSM WDSEL has the processor");
    assert_eq!(read(&mut bus, WATCHDOG + 8), 2);
    assert_eq!(read(&mut bus, PWM + 0x10), 0xffff, "peripherals were not selected");
    write(&mut bus, 0x4001_0008, 0);
    assert!(!bus.reset_by_watchdog(ResetReason::WatchdogForce));
    write(&mut bus, 0x4001_0008, 1 << 3);
    bus.reset_by_watchdog(ResetReason::WatchdogForce);
    assert_eq!(read(&mut bus, RESETS), 0x01ff_ffff, "with stage RESETS every peripheral is held");
}
