//! Flash through XIP_CTRL and SSI.

use super::{bus, read, reports, write};
use crate::ticks::Ticks;

const FLASH: u32 = 0x1000_0000;
const XIP_CTRL: u32 = 0x1400_0000;
const FLUSH: u32 = XIP_CTRL + 0x4;
const CTR_HIT: u32 = XIP_CTRL + 0xc;
const CTR_ACC: u32 = XIP_CTRL + 0x10;
const SSI: u32 = 0x1800_0000;

#[test]
fn the_first_access_misses_and_the_second_does_not() {
    let mut bus = bus();
    read(&mut bus, FLASH);
    // 20 serial clocks of two cycles, and 10 cycles around them.
    assert_eq!(bus.take_wait_cycles(), 50);
    read(&mut bus, FLASH);
    assert_eq!(bus.take_wait_cycles(), 0);
    assert_eq!((read(&mut bus, CTR_ACC), read(&mut bus, CTR_HIT)), (2, 1));
    bus.flush_cache();
    read(&mut bus, FLASH);
    assert_eq!(bus.take_wait_cycles(), 50);
    assert_eq!(reports(&bus), [""; 0]);
}

#[test]
fn instructions_come_two_at_a_time_and_one_word_ahead() {
    let mut bus = bus();
    let mut waits = |address| {
        bus.fetch(address).expect("flash");
        bus.take_wait_cycles() / 50
    };
    assert_eq!(waits(FLASH), 1);
    assert_eq!(waits(FLASH + 2), 1, "the next word is fetched meanwhile");
    assert_eq!(waits(FLASH + 4), 0);
    assert_eq!(waits(FLASH + 6), 1);
    assert_eq!(waits(FLASH + 18), 2, "a branch to the upper half of a word");
    assert_eq!(waits(FLASH + 20), 0);
    assert_eq!(waits(FLASH), 0);
}

#[test]
fn an_access_during_a_flush_waits_for_its_end() {
    let mut bus = bus();
    read(&mut bus, FLASH);
    bus.take_wait_cycles();
    write(&mut bus, FLUSH, 1);
    read(&mut bus, FLASH);
    assert_eq!(bus.take_wait_cycles(), 1024 + 50);
    bus.now += Ticks::from_millis(1);
    read(&mut bus, FLASH + 8);
    assert_eq!(bus.take_wait_cycles(), 50);
}

/// Neither the flash chip nor the SSI could do such a read.
#[test]
fn reads_that_the_flash_chip_would_not_understand_are_reported() {
    let mut bus = bus();
    write(&mut bus, SSI + 0x08, 0);
    read(&mut bus, FLASH + 0x10);
    assert_eq!(reports(&bus), ["Read of 0x10000010: ValueNotModelled x1"]);
}
