//! One UART against the register description of the datasheet (4.2.8) and the PL011 manual.

use super::*;

/// A bit at 1 Mbaud.
const BIT: u64 = 125;
const MODE_8N1_FIFO: u32 = 3 << 5 | FEN;
const ENABLED: u32 = UARTEN | TXE | RXE;

/// A UART at 125 MHz with these divisors and line control, enabled.
fn uart(integer: u32, fraction: u32, line_control: u32) -> Uart {
    let mut uart = Uart::default();
    uart.set_clock((125_000_000, 1));
    uart.set_transmit_pin(true);
    set(&mut uart, UARTIBRD, integer, Ticks::ZERO);
    set(&mut uart, UARTFBRD, fraction, Ticks::ZERO);
    set(&mut uart, UARTLCR_H, line_control, Ticks::ZERO);
    set(&mut uart, UARTCR, ENABLED, Ticks::ZERO);
    uart
}

/// 1 Mbaud 8N1: 125 MHz / 16 / 7.8125.
fn megabaud() -> Uart {
    uart(7, 52, MODE_8N1_FIFO)
}

fn set(uart: &mut Uart, offset: u32, value: u32, now: Ticks) {
    assert_eq!(uart.write(offset, RegisterWrite::plain(value), now), Written::Done);
}

fn get(uart: &mut Uart, offset: u32) -> u32 {
    uart.read(offset).expect("a register")
}

fn run(uart: &mut Uart, until: u64) {
    while uart.next_event() <= Ticks::new(until) {
        let at = uart.next_event();
        uart.advance(at, true);
    }
}

/// Receives good characters, the first one's stop bit at `start`, back to back at 1 Mbaud.
fn receive(uart: &mut Uart, start: u64, bytes: &[u8]) {
    for (i, byte) in (0..).zip(bytes) {
        uart.put_on_wire(Ticks::new(start + 10 * BIT * i), *byte, LineErrors::NONE);
    }
    run(uart, start + 10 * BIT * (bytes.len() as u64 - 1));
}

#[test]
fn ten_bytes_leave_back_to_back_at_exactly_one_megabaud() {
    let mut uart = megabaud();
    for byte in 0..10 {
        set(&mut uart, UARTDR, byte, Ticks::new(1000));
    }
    run(&mut uart, 1_000_000);
    let sent: Vec<Transmitted> = uart.take_transmitted().collect();
    assert_eq!(sent.len(), 10);
    for (i, character) in (0..).zip(&sent) {
        assert_eq!(character.start, Ticks::new(1000 + 10 * BIT * i));
        assert_eq!(character.end, character.start + Ticks::new(10 * BIT));
        assert_eq!(u64::from(character.byte), i);
    }
}

#[test]
fn a_fractional_bit_time_does_not_drift() {
    // 115200 baud: divisor 67.8125 (67 + 52/64), 10 bits are 10850.0 cycles; 67 + 53/64 gives
    // 10852.5.
    let mut uart = uart(67, 53, MODE_8N1_FIFO);
    for byte in 0..32 {
        set(&mut uart, UARTDR, byte, Ticks::ZERO);
    }
    run(&mut uart, 10_000_000);
    let sent: Vec<Transmitted> = uart.take_transmitted().collect();
    assert_eq!(sent[0].end, Ticks::new(10_853));
    assert_eq!(sent[1].end, Ticks::new(21_705));
    assert_eq!(sent[31].end, Ticks::new(32 * 108_525 / 10));
}

#[test]
fn parity_and_two_stop_bits_lengthen_a_character_and_the_line_shows_its_bits() {
    // 8E2.
    let mut uart = uart(7, 52, MODE_8N1_FIFO | PEN | 1 << 2 | STP2);
    set(&mut uart, UARTDR, 0b0100_0011, Ticks::ZERO);
    let levels: Vec<u32> =
        (0..12).map(|bit| u32::from(uart.transmit_line(Ticks::new(BIT * bit + 60)))).collect();
    assert_eq!(
        levels,
        [0, 1, 1, 0, 0, 0, 0, 1, 0, 1, 1, 1],
        "start, data from bit 0, even parity, two stops"
    );
    run(&mut uart, 10_000);
    assert_eq!(uart.take_transmitted().next().map(|c| c.end), Some(Ticks::new(12 * BIT)));
    assert!(uart.transmit_line(Ticks::new(10_000)), "idle");
    set(&mut uart, UARTLCR_H, MODE_8N1_FIFO | BRK, Ticks::new(10_000));
    assert!(!uart.transmit_line(Ticks::new(10_001)), "break");
}

#[test]
fn divisors_take_effect_with_the_next_write_of_line_control() {
    let mut uart = megabaud();
    set(&mut uart, UARTIBRD, 15, Ticks::ZERO);
    set(&mut uart, UARTFBRD, 40, Ticks::ZERO);
    set(&mut uart, UARTDR, 0, Ticks::ZERO);
    run(&mut uart, 100_000);
    set(&mut uart, UARTLCR_H, MODE_8N1_FIFO, Ticks::new(100_000));
    set(&mut uart, UARTDR, 0, Ticks::new(100_000));
    run(&mut uart, 200_000);
    let lengths: Vec<u64> = uart.take_transmitted().map(|c| (c.end - c.start).get()).collect();
    assert_eq!(lengths, [1250, 2500]);
}

#[test]
fn busy_and_fifo_flags_follow_the_transmitter() {
    const BUSY: u32 = 1 << 3;
    const TXFF: u32 = 1 << 5;
    const TXFE: u32 = 1 << 7;
    const RXFE: u32 = 1 << 4;
    let mut uart = megabaud();
    assert_eq!(get(&mut uart, UARTFR), TXFE | RXFE);
    set(&mut uart, UARTDR, 1, Ticks::ZERO);
    assert_eq!(get(&mut uart, UARTFR), TXFE | RXFE | BUSY, "in the shift register already");
    for byte in 0..40 {
        set(&mut uart, UARTDR, byte, Ticks::ZERO);
    }
    assert_eq!(get(&mut uart, UARTFR), RXFE | BUSY | TXFF);
    run(&mut uart, 33 * 10 * BIT - 1);
    assert_eq!(get(&mut uart, UARTFR), RXFE | BUSY | TXFE, "the last stop bit");
    run(&mut uart, 33 * 10 * BIT);
    assert_eq!(get(&mut uart, UARTFR), RXFE | TXFE);
    assert_eq!(
        uart.take_transmitted().count(),
        33,
        "32 in the FIFO and one in the shift register; the rest is lost"
    );
}

#[test]
fn the_transmit_interrupt_comes_on_the_way_down_through_its_level() {
    let mut uart = megabaud();
    set(&mut uart, UARTIFLS, 0, Ticks::ZERO);
    set(&mut uart, UARTIMSC, TX_INTERRUPT, Ticks::ZERO);
    assert!(!uart.interrupt(), "not merely because the FIFO is empty");
    for byte in 0..6 {
        set(&mut uart, UARTDR, byte, Ticks::ZERO);
    }
    assert!(!uart.interrupt(), "five in the FIFO, one being sent");
    run(&mut uart, 10 * BIT);
    assert!(uart.interrupt(), "four left");
    assert_eq!(get(&mut uart, UARTMIS), TX_INTERRUPT);
    set(&mut uart, UARTICR, TX_INTERRUPT, Ticks::new(10 * BIT));
    assert!(!uart.interrupt());
}

#[test]
fn received_bytes_raise_the_level_interrupt_and_reading_lowers_it() {
    let mut uart = megabaud();
    set(&mut uart, UARTIFLS, 1 << 3, Ticks::ZERO);
    set(&mut uart, UARTIMSC, RX_INTERRUPT, Ticks::ZERO);
    receive(&mut uart, 1250, &[1, 2, 3, 4, 5, 6, 7]);
    assert!(!uart.interrupt());
    receive(&mut uart, 10_000, &[8]);
    assert!(uart.interrupt(), "a quarter full");
    assert_eq!(get(&mut uart, UARTDR), 1);
    assert!(!uart.interrupt());
    for byte in 2..=8 {
        assert_eq!(get(&mut uart, UARTDR), byte);
    }
    assert_eq!(get(&mut uart, UARTFR) >> 4 & 1, 1, "empty");
}

#[test]
fn the_receive_timeout_comes_32_bits_after_the_last_character() {
    let mut uart = megabaud();
    set(&mut uart, UARTIMSC, RECEIVE_TIMEOUT, Ticks::ZERO);
    receive(&mut uart, 1250, &[1, 2]);
    let last_stop_bit = 2500;
    run(&mut uart, last_stop_bit + 32 * BIT - 1);
    assert!(!uart.interrupt());
    run(&mut uart, last_stop_bit + 32 * BIT);
    assert!(uart.interrupt());
    get(&mut uart, UARTDR);
    assert!(uart.interrupt(), "one is left");
    get(&mut uart, UARTDR);
    assert!(!uart.interrupt());
}

#[test]
fn line_errors_travel_with_their_character_and_raise_their_interrupts() {
    let mut uart = megabaud();
    let framing = LineErrors { framing: true, ..LineErrors::NONE };
    let parity = LineErrors { parity: true, ..LineErrors::NONE };
    let line_break = LineErrors { line_break: true, ..LineErrors::NONE };
    for (i, errors) in [LineErrors::NONE, framing, parity, line_break].into_iter().enumerate() {
        uart.put_on_wire(Ticks::new(1250 * (i as u64 + 1)), 0x55, errors);
    }
    run(&mut uart, 5000);
    assert_eq!(get(&mut uart, UARTRIS) & ERROR_INTERRUPTS, FRAMING_ERROR | PARITY_ERROR | BREAK_ERROR);
    assert_eq!(get(&mut uart, UARTDR), 0x55);
    assert_eq!(get(&mut uart, UARTRSR), 0);
    assert_eq!(get(&mut uart, UARTDR), 0x155);
    assert_eq!(get(&mut uart, UARTRSR), 1);
    assert_eq!(get(&mut uart, UARTDR), 0x255);
    assert_eq!(get(&mut uart, UARTDR), 0x500, "a break is a zero with a framing error");
    assert_eq!(get(&mut uart, UARTRSR), 5);
    set(&mut uart, UARTRSR, 0, Ticks::new(5000));
    assert_eq!(get(&mut uart, UARTRSR), 0);
}

#[test]
fn the_33rd_byte_overruns_and_the_next_one_carries_the_mark() {
    let mut uart = megabaud();
    set(&mut uart, UARTIMSC, OVERRUN_ERROR, Ticks::ZERO);
    receive(&mut uart, 1250, &[7; 32]);
    assert!(!uart.interrupt());
    receive(&mut uart, 50_000, &[8]);
    assert!(uart.interrupt());
    assert_eq!(uart.overruns(), 1);
    assert_eq!(get(&mut uart, UARTDR), 7);
    receive(&mut uart, 60_000, &[9]);
    for _ in 0..31 {
        assert_eq!(get(&mut uart, UARTDR), 7);
    }
    assert_eq!(get(&mut uart, UARTDR), 0x809);
}

#[test]
fn without_fifos_one_character_fits() {
    let mut uart = uart(7, 52, 3 << 5);
    set(&mut uart, UARTIMSC, RX_INTERRUPT, Ticks::ZERO);
    receive(&mut uart, 1250, &[1]);
    assert!(uart.interrupt());
    receive(&mut uart, 2500, &[2]);
    assert_eq!(uart.overruns(), 1);
    assert_eq!(get(&mut uart, UARTDR), 1);
    assert!(!uart.interrupt());
}

#[test]
fn a_disabled_or_unconnected_receiver_hears_nothing() {
    let mut uart = megabaud();
    set(&mut uart, UARTCR, UARTEN | TXE, Ticks::ZERO);
    receive(&mut uart, 1250, &[1]);
    assert_eq!(get(&mut uart, UARTFR) >> 4 & 1, 1);
    set(&mut uart, UARTCR, ENABLED, Ticks::new(1250));
    uart.put_on_wire(Ticks::new(2500), 2, LineErrors::NONE);
    uart.advance(Ticks::new(2500), false);
    assert_eq!(get(&mut uart, UARTFR) >> 4 & 1, 1);
}

#[test]
fn dma_requests_follow_fifos_enables_and_errors() {
    let mut uart = megabaud();
    assert!(!uart.transmit_request() && !uart.receive_request(), "not enabled");
    set(&mut uart, UARTDMACR, TXDMAE | RXDMAE | DMAONERR, Ticks::ZERO);
    assert!(uart.transmit_request() && !uart.receive_request());
    receive(&mut uart, 1250, &[1]);
    assert!(uart.receive_request());
    set(&mut uart, UARTIMSC, FRAMING_ERROR, Ticks::new(1250));
    uart.put_on_wire(Ticks::new(2500), 2, LineErrors { framing: true, ..LineErrors::NONE });
    run(&mut uart, 2500);
    assert!(!uart.receive_request(), "DMAONERR");
    set(&mut uart, UARTICR, FRAMING_ERROR, Ticks::new(2500));
    assert!(uart.receive_request());
    for byte in 0..33 {
        set(&mut uart, UARTDR, byte, Ticks::new(2500));
    }
    assert!(!uart.transmit_request(), "full");
}

#[test]
fn what_nobody_models_is_refused() {
    let mut uart = megabaud();
    assert_eq!(
        uart.write(UARTCR, RegisterWrite::plain(ENABLED | LBE), Ticks::ZERO),
        Written::ValueNotModelled
    );
    assert_eq!(uart.write(0x050, RegisterWrite::plain(0), Ticks::ZERO), Written::NotModelled);
    assert_eq!(uart.read(0x04c), None);
}

#[test]
fn a_reset_empties_fifos_and_keeps_what_is_on_the_wire() {
    let mut uart = megabaud();
    set(&mut uart, UARTDR, 1, Ticks::ZERO);
    uart.put_on_wire(Ticks::new(99_999), 2, LineErrors::NONE);
    uart.reset();
    assert_eq!(get(&mut uart, UARTCR), TXE | RXE);
    assert_eq!(uart.take_transmitted().count(), 1);
    assert_eq!(uart.next_event(), Ticks::new(99_999));
}
