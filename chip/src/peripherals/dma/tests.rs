//! The channels' registers and sequencing (2.5); transfers over the bus are tested in
//! `bus/tests/dma.rs`.

use super::*;

const CTRL_TRIG: u32 = 0x0c;
const EN: u32 = 1;
const INCREMENT_BOTH: u32 = 3 << 4;
const WORDS: u32 = 2 << 2;
const BUSY: u32 = 1 << 24;

fn set(dma: &mut Dma, offset: u32, value: u32) {
    assert_eq!(dma.write(offset, RegisterWrite::plain(value), Ticks::ZERO), Written::Done);
}

fn get(dma: &Dma, offset: u32) -> u32 {
    dma.read(offset).expect("a register")
}

/// CTRL of a channel that chains to nobody and is always requested.
fn control(channel: u32, extra: u32) -> u32 {
    EN | WORDS | INCREMENT_BOTH | channel << 11 | 0x3f << 15 | extra
}

/// Sets addresses and count of a channel.
fn prepare(dma: &mut Dma, channel: u32, read: u32, write: u32, count: u32) {
    let base = CHANNEL_STRIDE * channel;
    set(dma, base, read);
    set(dma, base + 4, write);
    set(dma, base + 8, count);
}

/// Completes transfers of one channel, noting the addresses.
fn transfers(dma: &mut Dma, channel: usize, count: usize) -> Vec<(u32, u32)> {
    let mut made = Vec::new();
    for _ in 0..count {
        let transfer = dma.channels[channel].transfer();
        made.push((transfer.from, transfer.to));
        dma.complete(channel, Ok(()), Ticks::ZERO);
    }
    made
}

#[test]
fn all_four_alias_blocks_show_the_same_registers() {
    let mut dma = Dma::default();
    prepare(&mut dma, 2, 0x100, 0x200, 3);
    let base = 2 * CHANNEL_STRIDE;
    set(&mut dma, base + 0x10, control(2, 0) & !EN);
    let c = control(2, 0) & !EN;
    let block = |start: u32| [0, 4, 8, 12].map(|i| get(&dma, base + start + i));
    assert_eq!(block(0x00), [0x100, 0x200, 3, c]);
    assert_eq!(block(0x10), [c, 0x100, 0x200, 3]);
    assert_eq!(block(0x20), [c, 3, 0x100, 0x200]);
    assert_eq!(block(0x30), [c, 0x200, 3, 0x100]);
}

#[test]
fn the_last_register_of_every_block_triggers() {
    for (trigger, value) in [(0x0c, control(0, 0)), (0x1c, 5), (0x2c, 0x200), (0x3c, 0x100)] {
        let mut dma = Dma::default();
        prepare(&mut dma, 0, 0x100, 0x200, 5);
        set(&mut dma, 0x10, control(0, 0));
        assert_eq!(get(&dma, CTRL_TRIG) & BUSY, 0, "CTRL without trigger");
        set(&mut dma, trigger, value);
        assert_eq!(get(&dma, CTRL_TRIG) & BUSY, BUSY, "{trigger:#x}");
    }
}

#[test]
fn a_sequence_counts_down_interrupts_and_reloads() {
    let mut dma = Dma::default();
    prepare(&mut dma, 1, 0x1000, 0x2000, 2);
    set(&mut dma, INTE0, 1 << 1);
    set(&mut dma, CHANNEL_STRIDE + CTRL_TRIG, control(1, 0));
    assert_eq!(transfers(&mut dma, 1, 1), [(0x1000, 0x2000)]);
    assert_eq!(get(&dma, CHANNEL_STRIDE + 8), 1);
    assert!(!dma.interrupt(0));
    transfers(&mut dma, 1, 1);
    assert!(dma.interrupt(0) && !dma.interrupt(1));
    assert_eq!(get(&dma, CHANNEL_STRIDE + CTRL_TRIG) & BUSY, 0);
    assert_eq!(get(&dma, CHANNEL_STRIDE), 0x1008, "addresses stay where they are");
    set(&mut dma, INTS0, 1 << 1);
    assert!(!dma.interrupt(0));
    set(&mut dma, MULTI_CHAN_TRIGGER, 1 << 1);
    assert_eq!(get(&dma, CHANNEL_STRIDE + 8), 2, "the count as written");
}

#[test]
fn rings_wrap_one_of_the_addresses() {
    let ring_of_8_bytes = 3 << 6;
    let mut dma = Dma::default();
    prepare(&mut dma, 0, 0x1004, 0x2000, 4);
    set(&mut dma, CTRL_TRIG, control(0, ring_of_8_bytes));
    assert_eq!(
        transfers(&mut dma, 0, 4),
        [(0x1004, 0x2000), (0x1000, 0x2004), (0x1004, 0x2008), (0x1000, 0x200c)]
    );
    let on_writes = 1 << 10;
    prepare(&mut dma, 0, 0x1000, 0x2000, 3);
    set(&mut dma, CTRL_TRIG, control(0, ring_of_8_bytes | on_writes));
    assert_eq!(transfers(&mut dma, 0, 3), [(0x1000, 0x2000), (0x1004, 0x2004), (0x1008, 0x2000)]);
}

#[test]
fn a_channel_chains_to_the_next() {
    let mut dma = Dma::default();
    prepare(&mut dma, 4, 0x3000, 0x4000, 1);
    set(&mut dma, 4 * CHANNEL_STRIDE + 0x10, control(4, 0));
    prepare(&mut dma, 0, 0x1000, 0x2000, 1);
    set(&mut dma, CTRL_TRIG, control(0, 0) & !(15 << 11) | 4 << 11);
    assert!(!dma.channels[4].is_busy());
    transfers(&mut dma, 0, 1);
    assert!(!dma.channels[0].is_busy() && dma.channels[4].is_busy());
}

#[test]
fn with_irq_quiet_only_a_null_trigger_interrupts() {
    let quiet = 1 << 21;
    let mut dma = Dma::default();
    prepare(&mut dma, 0, 0x1000, 0x2000, 1);
    set(&mut dma, CTRL_TRIG, control(0, quiet));
    transfers(&mut dma, 0, 1);
    assert_eq!(get(&dma, INTR), 0);
    set(&mut dma, 0x3c, 0);
    assert_eq!(get(&dma, INTR), 1);
    assert!(!dma.channels[0].is_busy(), "a null trigger starts nothing");
}

#[test]
fn high_priority_goes_first_and_the_rest_takes_turns() {
    let mut dma = Dma::default();
    for channel in [0, 1, 2] {
        prepare(&mut dma, channel, 0x1000, 0x2000, 10);
        let priority = if channel == 2 { 2 } else { 0 };
        set(&mut dma, CHANNEL_STRIDE * channel + CTRL_TRIG, control(channel, priority));
    }
    let mut turns = Vec::new();
    for _ in 0..14 {
        let channel = dma.choose(|_| true).expect("all are ready");
        turns.push(channel);
        dma.complete(channel, Ok(()), Ticks::ZERO);
    }
    assert_eq!(turns[..10], [2; 10]);
    assert_eq!(turns[10..], [0, 1, 0, 1]);
}

#[test]
fn abort_stops_without_an_interrupt() {
    let mut dma = Dma::default();
    prepare(&mut dma, 3, 0x1000, 0x2000, 10);
    set(&mut dma, 3 * CHANNEL_STRIDE + CTRL_TRIG, control(3, 0));
    transfers(&mut dma, 3, 4);
    set(&mut dma, CHAN_ABORT, 1 << 3);
    assert!(!dma.any_busy());
    assert_eq!((get(&dma, INTR), get(&dma, CHAN_ABORT)), (0, 0));
}

#[test]
fn pacing_timers_request_x_of_y_cycles() {
    let mut dma = Dma::default();
    dma.set_clock((125_000_000, 1), Ticks::ZERO);
    set(&mut dma, TIMER0, 1 << 16 | 250);
    assert_eq!(dma.next_event(), Ticks::NEVER, "nobody waits for it");
    prepare(&mut dma, 0, 0x1000, 0x2000, 10);
    set(&mut dma, CTRL_TRIG, control(0, 0) & !(0x3f << 15) | FIRST_TIMER_REQUEST << 15);
    assert_eq!(dma.choose(|_| false), None);
    assert_eq!(dma.next_event(), Ticks::new(250));
    dma.advance(Ticks::new(250));
    assert_eq!(dma.choose(|_| false), Some(0));
    dma.complete(0, Ok(()), Ticks::new(250));
    assert_eq!(dma.choose(|_| false), None, "one transfer a request");
    assert_eq!(dma.next_event(), Ticks::new(500));
}

#[test]
fn what_a_timer_requested_before_the_trigger_is_lost() {
    let mut dma = Dma::default();
    dma.set_clock((125_000_000, 1), Ticks::ZERO);
    set(&mut dma, TIMER0, 1 << 16 | 250);
    prepare(&mut dma, 0, 0x1000, 0x2000, 10);
    let paced = control(0, 0) & !(0x3f << 15) | FIRST_TIMER_REQUEST << 15;
    assert_eq!(dma.write(CTRL_TRIG, RegisterWrite::plain(paced), Ticks::new(10_100)), Written::Done);
    dma.advance(Ticks::new(10_100));
    assert_eq!(dma.choose(|_| false), None);
    assert_eq!(dma.next_event(), Ticks::new(10_250));
}

#[test]
fn errors_stop_the_channel_and_are_cleared_by_ones() {
    let mut dma = Dma::default();
    prepare(&mut dma, 0, 0x1000, 0x2000, 10);
    set(&mut dma, CTRL_TRIG, control(0, 0));
    dma.complete(0, Err(TransferError::Read), Ticks::ZERO);
    assert!(!dma.any_busy());
    assert_eq!(get(&dma, CTRL_TRIG) >> 29, 0b110, "AHB_ERROR, READ_ERROR");
    set(&mut dma, 0x10, control(0, 1 << 30));
    assert_eq!(get(&dma, CTRL_TRIG) >> 29, 0);
}

#[test]
fn the_sniffer_is_refused() {
    let mut dma = Dma::default();
    let sniff = RegisterWrite::plain(control(0, 1 << 23));
    assert_eq!(dma.write(CTRL_TRIG, sniff, Ticks::ZERO), Written::ValueNotModelled);
    assert_eq!(dma.write(0x434, RegisterWrite::plain(1), Ticks::ZERO), Written::NotModelled);
}
