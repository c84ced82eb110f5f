use super::{RESETS, SIO, clocked_bus, read, reports, run, select_function, write};
use crate::bus::{Bus, Level};
use crate::parts::Ads1115;
use crate::ticks::Ticks;

const I2C0: u32 = 0x4004_4000;
const IC_TAR: u32 = I2C0 + 0x04;
const IC_DATA_CMD: u32 = I2C0 + 0x10;
const IC_INTR_MASK: u32 = I2C0 + 0x30;
const IC_RAW_INTR_STAT: u32 = I2C0 + 0x34;
const IC_CLR_INTR: u32 = I2C0 + 0x40;
const IC_ENABLE: u32 = I2C0 + 0x6c;
const IC_TX_ABRT_SOURCE: u32 = I2C0 + 0x80;
const I2C0_IRQ: u32 = 1 << 23;
const GPIO_OE_SET: u32 = SIO + 0x24;
const GPIO_OE_CLR: u32 = SIO + 0x28;
const FUNCTION_I2C: u32 = 3;
const STOP: u32 = 1 << 9;
const READ: u32 = 1 << 8;

/// I2C0 on GPIO 4 and 5 with an ADS1115 at 0x48.
fn i2c_bus() -> Bus {
    let mut bus = clocked_bus();
    bus.wire_i2c(4, 5);
    bus.i2c[0].wires.attach(0x48, Box::new(Ads1115::new()));
    select_function(&mut bus, 4, FUNCTION_I2C);
    select_function(&mut bus, 5, FUNCTION_I2C);
    write(&mut bus, IC_TAR, 0x48);
    write(&mut bus, IC_ENABLE, 1);
    bus
}

/// Reads the configuration register.
fn transfer(bus: &mut Bus) {
    write(bus, IC_DATA_CMD, 0x01);
    write(bus, IC_DATA_CMD, READ);
    write(bus, IC_DATA_CMD, READ | STOP);
    let later = bus.now + Ticks::from_millis(1);
    run(bus, later);
}

#[test]
fn a_part_is_read_through_the_pins() {
    let mut bus = i2c_bus();
    write(&mut bus, IC_INTR_MASK, 1 << 9);
    transfer(&mut bus);
    assert_eq!(bus.interrupt_lines() & I2C0_IRQ, I2C0_IRQ, "STOP_DET");
    read(&mut bus, IC_CLR_INTR);
    assert_eq!(bus.interrupt_lines() & I2C0_IRQ, 0, "reading clears");
    assert_eq!([0; 2].map(|_| read(&mut bus, IC_DATA_CMD)), [0x85, 0x83]);
    assert_eq!(reports(&bus), [""; 0]);
}

#[test]
fn a_part_is_not_there_while_other_pins_are_switched() {
    let mut bus = i2c_bus();
    select_function(&mut bus, 4, 5);
    select_function(&mut bus, 5, 5);
    select_function(&mut bus, 0, FUNCTION_I2C);
    select_function(&mut bus, 1, FUNCTION_I2C);
    transfer(&mut bus);
    assert_eq!(read(&mut bus, IC_RAW_INTR_STAT) & 1 << 9, 0, "pulled down: the lines are not free");
    bus.set_outside_level(0, Level::High);
    bus.set_outside_level(1, Level::High);
    run(&mut bus, Ticks::from_millis(3));
    assert_eq!(read(&mut bus, IC_TX_ABRT_SOURCE) & 1, 1, "nobody acknowledges");
}

#[test]
fn nine_clocks_from_the_pins_free_the_lines() {
    let mut bus = i2c_bus();
    bus.hold_sda(0, 9);
    transfer(&mut bus);
    assert_eq!(bus.pin_level(4, bus.now), Level::Low);
    assert_eq!(read(&mut bus, IC_RAW_INTR_STAT) & 1 << 10, 0, "not even a START");
    // The program takes the pins, and pulls SCL low by enabling an output of 0.
    select_function(&mut bus, 4, 5);
    select_function(&mut bus, 5, 5);
    for clock in 1..=9 {
        assert_eq!(bus.pin_level(4, bus.now), Level::Low, "clock {clock}");
        write(&mut bus, GPIO_OE_SET, 1 << 5);
        assert_eq!(bus.pin_level(5, bus.now), Level::Low);
        write(&mut bus, GPIO_OE_CLR, 1 << 5);
        assert_eq!(bus.pin_level(5, bus.now), Level::High);
    }
    assert_eq!(bus.pin_level(4, bus.now), Level::High);
    assert_eq!(read(&mut bus, SIO + 0x04) >> 4 & 1, 1, "the program sees it");
    select_function(&mut bus, 4, FUNCTION_I2C);
    select_function(&mut bus, 5, FUNCTION_I2C);
    let later = bus.now + Ticks::from_millis(1);
    run(&mut bus, later);
    assert_eq!([0; 2].map(|_| read(&mut bus, IC_DATA_CMD)), [0x85, 0x83], "the transfer goes on");
}

#[test]
fn a_line_that_is_low_for_ever_is_not_freed() {
    let mut bus = i2c_bus();
    bus.set_outside_level(4, Level::Low);
    select_function(&mut bus, 5, 5);
    for _ in 0..20 {
        write(&mut bus, GPIO_OE_SET, 1 << 5);
        write(&mut bus, GPIO_OE_CLR, 1 << 5);
    }
    assert_eq!(bus.pin_level(4, bus.now), Level::Low);
    bus.set_outside_level(4, Level::Floating);
    assert_eq!(bus.pin_level(4, bus.now), Level::High, "its pull-up");
}

#[test]
fn parts_stay_when_the_chip_is_reset_or_powered() {
    let mut bus = i2c_bus();
    write(&mut bus, RESETS, 1 << 3);
    write(&mut bus, RESETS, 0);
    assert_eq!(read(&mut bus, IC_ENABLE), 0);
    write(&mut bus, IC_TAR, 0x48);
    write(&mut bus, IC_ENABLE, 1);
    transfer(&mut bus);
    assert_eq!(read(&mut bus, IC_DATA_CMD), 0x85);
    bus.power_cycle();
    assert_eq!(bus.pin_level(4, bus.now), Level::High, "still wired");
    assert!(bus.i2c[0].wires.part_mut(0x48).is_some());
}

#[test]
#[should_panic(expected = "GPIO5 and GPIO4 are no SDA and SCL of a block")]
fn lines_must_not_be_swapped() {
    clocked_bus().wire_i2c(5, 4);
}
