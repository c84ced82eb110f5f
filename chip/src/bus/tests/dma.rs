//! DMA transfers over the bus, paced by the peripherals.

use super::{ADC, DMA, FUNCTION_UART, PWM, UART0, clocked_bus, read, reports, run, select_function, write};
use crate::bus::Bus;
use crate::peripherals::uart::LineErrors;
use crate::ticks::Ticks;

const SRAM: u32 = 0x2000_0000;
const DMA_IRQ_0: u32 = 1 << 11;
const BUSY: u32 = 1 << 24;

const UART0_TX: u32 = 20;
const UART0_RX: u32 = 21;
const PWM_WRAP3: u32 = 27;
const ADC_REQUEST: u32 = 36;
const PERMANENT: u32 = 0x3f;

const BYTES: u32 = 0;
const HALFWORDS: u32 = 1 << 2;
const WORDS: u32 = 2 << 2;
const READ_ON: u32 = 1 << 4;
const WRITE_ON: u32 = 1 << 5;
const SWAP: u32 = 1 << 22;

/// Starts channel `channel` without chaining.
fn start(bus: &mut Bus, channel: u32, from: u32, to: u32, count: u32, request: u32, options: u32) {
    let base = DMA + 0x40 * channel;
    write(bus, base, from);
    write(bus, base + 4, to);
    write(bus, base + 8, count);
    write(bus, base + 0xc, 1 | options | channel << 11 | request << 15);
}

fn is_busy(bus: &mut Bus, channel: u32) -> bool {
    read(bus, DMA + 0x40 * channel + 0xc) & BUSY != 0
}

/// UART0 at 1 Mbaud with DMA requests, on pins 0 and 1.
fn uart(bus: &mut Bus) {
    select_function(bus, 0, FUNCTION_UART);
    select_function(bus, 1, FUNCTION_UART);
    for (offset, value) in [(0x24, 7), (0x28, 52), (0x2c, 0x70), (0x30, 0x301), (0x48, 3)] {
        write(bus, UART0 + offset, value);
    }
}

#[test]
fn memory_is_copied_one_transfer_a_cycle() {
    let mut bus = clocked_bus();
    for i in 0..16 {
        write(&mut bus, SRAM + 4 * i, i);
    }
    write(&mut bus, DMA + 0x404, 1);
    let begin = bus.now;
    start(&mut bus, 0, SRAM, SRAM + 0x100, 16, PERMANENT, WORDS | READ_ON | WRITE_ON);
    run(&mut bus, begin + Ticks::new(14));
    assert!(is_busy(&mut bus, 0), "the sixteenth is one cycle away");
    assert_eq!(bus.interrupt_lines(), 0);
    run(&mut bus, begin + Ticks::new(15));
    assert!(!is_busy(&mut bus, 0));
    assert_eq!(bus.interrupt_lines(), DMA_IRQ_0);
    assert!((0..16).all(|i| bus.read32(SRAM + 0x100 + 4 * i) == Ok(i)));
}

#[test]
fn sizes_and_byte_order() {
    let mut bus = clocked_bus();
    write(&mut bus, SRAM, 0x4433_2211);
    write(&mut bus, SRAM + 4, 0);
    start(&mut bus, 0, SRAM + 1, SRAM + 4, 2, PERMANENT, BYTES | READ_ON);
    let later = bus.now + Ticks::new(10);
    run(&mut bus, later);
    assert_eq!(read(&mut bus, SRAM + 4), 0x33, "both bytes to the same place");
    start(&mut bus, 0, SRAM, SRAM + 4, 1, PERMANENT, WORDS | SWAP);
    assert_eq!(read(&mut bus, SRAM + 4), 0x1122_3344);
    let later = bus.now + Ticks::new(10);
    run(&mut bus, later);
    start(&mut bus, 0, SRAM + 2, SRAM + 4, 1, PERMANENT, HALFWORDS | SWAP);
    assert_eq!(read(&mut bus, SRAM + 4), 0x1122_3344 & 0xffff_0000 | 0x3344);
}

#[test]
fn ten_bytes_go_from_memory_to_the_wire_back_to_back() {
    let mut bus = clocked_bus();
    uart(&mut bus);
    for i in 0..10 {
        bus.write8(SRAM + i, 0x30 + i as u8).expect("SRAM");
    }
    let begin = bus.now;
    start(&mut bus, 0, SRAM, UART0, 10, UART0_TX, BYTES | READ_ON);
    run(&mut bus, begin + Ticks::from_micros(200));
    let sent: Vec<_> = bus.uarts[0].take_transmitted().collect();
    assert_eq!(sent.iter().map(|c| c.byte).collect::<Vec<_>>(), b"0123456789");
    assert_eq!(sent[0].start, begin);
    assert_eq!(sent[9].end, begin + Ticks::from_micros(100));
}

#[test]
fn received_bytes_arrive_in_memory_at_their_stop_bits() {
    let mut bus = clocked_bus();
    uart(&mut bus);
    start(&mut bus, 1, UART0, SRAM, 4, UART0_RX, BYTES | WRITE_ON);
    let begin = bus.now;
    for (i, byte) in (1..).zip(b"abcd") {
        bus.uarts[0].put_on_wire(begin + Ticks::from_micros(10 * i), *byte, LineErrors::NONE);
    }
    bus.outside_changed();
    run(&mut bus, begin + Ticks::from_micros(40) - Ticks::new(1));
    assert_eq!(read(&mut bus, SRAM), 0xa563_6261, "three so far");
    assert!(is_busy(&mut bus, 1));
    run(&mut bus, begin + Ticks::from_micros(40));
    assert_eq!(read(&mut bus, SRAM), 0x6463_6261);
    assert!(!is_busy(&mut bus, 1));
    assert_eq!(read(&mut bus, UART0 + 0x18) >> 4 & 1, 1, "FIFO empty");
}

#[test]
fn adc_results_go_to_memory_in_round_robin() {
    let mut bus = clocked_bus();
    for channel in 0..4 {
        bus.adc.set_input(channel, 0x100 * (channel as u16 + 1));
    }
    write(&mut bus, ADC + 8, 1 | 1 << 3 | 1 << 24);
    start(&mut bus, 2, ADC + 0xc, SRAM, 8, ADC_REQUEST, HALFWORDS | WRITE_ON);
    let begin = bus.now;
    write(&mut bus, ADC, 1 | 1 << 3 | 0b1111 << 16);
    run(&mut bus, begin + Ticks::from_micros(16));
    let results: Vec<u16> = (0..8).map(|i| bus.read16(SRAM + 2 * i).expect("SRAM")).collect();
    assert_eq!(results, [0x100, 0x200, 0x300, 0x400, 0x100, 0x200, 0x300, 0x400]);
    assert!(!is_busy(&mut bus, 2));
    assert_eq!(read(&mut bus, ADC + 8) >> 11 & 1, 0, "nothing overflowed");
}

#[test]
fn a_pwm_wrap_moves_one_word() {
    let mut bus = clocked_bus();
    let slice = PWM + 3 * 0x14;
    write(&mut bus, slice + 0x10, 999);
    start(&mut bus, 0, SRAM, SRAM + 0x100, 5, PWM_WRAP3, WORDS | READ_ON | WRITE_ON);
    let begin = bus.now;
    write(&mut bus, slice, 1);
    run(&mut bus, begin + Ticks::new(999));
    assert_eq!(read(&mut bus, DMA + 8), 5);
    run(&mut bus, begin + Ticks::new(3500));
    assert_eq!(read(&mut bus, DMA + 8), 2, "three wraps");
}

#[test]
fn a_chain_of_control_blocks_runs_by_itself() {
    let mut bus = clocked_bus();
    // Channel 1 copies (count, address) pairs into channel 0's alias 3, whose last register
    // triggers.
    for (i, word) in (0..).zip([1, SRAM + 0x40, 2, SRAM + 0x44, 0, 0]) {
        write(&mut bus, SRAM + 4 * i, word);
    }
    for i in 0..3 {
        write(&mut bus, SRAM + 0x40 + 4 * i, 0xa0 + i);
    }
    write(&mut bus, DMA + 4, SRAM + 0x80);
    write(&mut bus, DMA + 0x10, 1 | WORDS | READ_ON | WRITE_ON | 1 << 11 | PERMANENT << 15 | 1 << 21);
    let ring_of_8_bytes_on_writes = 3 << 6 | 1 << 10;
    let options = WORDS | READ_ON | WRITE_ON | ring_of_8_bytes_on_writes;
    start(&mut bus, 1, SRAM, DMA + 0x38, 2, PERMANENT, options);
    let end = bus.now + Ticks::new(100);
    run(&mut bus, end);
    let copied: Vec<u32> = (0..3).map(|i| read(&mut bus, SRAM + 0x80 + 4 * i)).collect();
    assert_eq!(copied, [0xa0, 0xa1, 0xa2]);
    assert_eq!(read(&mut bus, DMA + 0x400) & 1, 1, "the null trigger at the end interrupts");
    assert_eq!(reports(&bus), [""; 0]);
}

#[test]
fn a_bad_address_stops_the_channel_with_an_error() {
    let mut bus = clocked_bus();
    start(&mut bus, 0, 0x3000_0000, SRAM, 1, PERMANENT, WORDS);
    assert_eq!(read(&mut bus, DMA + 0xc) >> 29, 0b110, "AHB_ERROR, READ_ERROR");
    start(&mut bus, 1, SRAM, 0x1100_0000, 1, PERMANENT, WORDS);
    let end = bus.now + Ticks::new(10);
    run(&mut bus, end);
    assert_eq!(read(&mut bus, DMA + 0x4c) >> 29, 0b101, "AHB_ERROR, WRITE_ERROR");
    start(&mut bus, 2, 0xd000_0000, SRAM, 1, PERMANENT, WORDS);
    let end = bus.now + Ticks::new(10);
    run(&mut bus, end);
    assert_eq!(read(&mut bus, DMA + 0x8c) >> 29, 0b110, "the DMA does not reach SIO");
}
