//! The firmware on the bus, to the tick: when it answers, how, and when not.
//!
//! `cargo test -p system-tests --test firmware bus:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

use pneudrive_chip::{Level, LineErrors, Ticks};
use pneudrive_protocol::pages::{PageEntry, SessionOffer};
use pneudrive_protocol::pulse::{Parts, pulse};
use pneudrive_protocol::{
    Address, AnswerDecoder, CheckedPacket, Counts, Direction, Echo, Heard, PageRequest, RequestNumber,
    Sequence, Session,
};
use system_tests::chip_bench::{Answer, BUS, CHARACTER, ChipBench, DRIVER_ENABLE, packet, print_delays};

/// A host whose driver a 555 of the boards' kind enables holds the line for up to 113.6 us from its
/// first start bit.
const EARLIEST: Ticks = Ticks::new(1_700);
const LATEST: Ticks = Ticks::from_micros(20);

fn assert_on_time_and_back_to_back(answer: &Answer) {
    let delay_us = answer.delay.as_micros();
    assert!(answer.delay >= EARLIEST && answer.delay <= LATEST, "the answer began after {delay_us} us");
    assert_eq!(answer.characters.len(), 10);
    for pair in answer.characters.windows(2) {
        assert_eq!(pair[0].end, pair[1].start, "a pause inside the answer");
    }
    let spoken = answer.characters[9].end.saturating_sub(answer.characters[0].start);
    let enabled_ns = pulse(976, Parts::ORIGINAL).shortest_ns;
    assert!(spoken.get() * 8 < enabled_ns, "{} us is longer than the 555's pulse", spoken.as_micros());
}

/// Exchanges at every phase of the control loop and of the log, which writes once a second.
fn delays(bench: &mut ChipBench, mut request: impl FnMut(u32) -> [u8; 10]) -> Vec<Ticks> {
    (0..3_000)
        .map(|n| {
            let answer = bench.exchange_bytes(&request(n));
            let answer = answer.unwrap_or_else(|| panic!("request {n} was not answered"));
            assert_on_time_and_back_to_back(&answer);
            bench.run(Ticks::new(u64::from(n) * 7 % 20_011));
            answer.delay
        })
        .collect()
}

#[test]
fn answers_begin_after_the_hosts_pulse_and_within_20_us_and_go_out_back_to_back() {
    let mut bench = ChipBench::booted(0);
    let mut delays = delays(&mut bench, |n| packet(0, [n as u16 % 1024; 4]).encode());
    print_delays("unchecked", &mut delays);
    assert_eq!(bench.chip.uart_overruns(BUS), 0);
}

/// Once a second the log is written, in critical sections of some 20 us each: they must leave the
/// bus's interrupts alone.
#[test]
fn an_answer_does_not_wait_for_the_log() {
    let mut bench = ChipBench::running(0);
    let _ = bench.chip.take_rtt();
    let mut before = bench.clone();
    while bench.chip.take_rtt().is_empty() {
        before = bench.clone();
        bench.run(Ticks::from_micros(100));
    }
    let mut delays: Vec<Ticks> = (0..150)
        .map(|n| {
            let mut bench = before.clone();
            bench.run(Ticks::from_micros(n * 3));
            let answer = bench.exchange(packet(0, [102; 4]));
            let answer = answer.unwrap_or_else(|| panic!("not answered {} us after the log began", n * 3));
            assert_on_time_and_back_to_back(&answer);
            answer.delay
        })
        .collect();
    delays.sort();
    print_delays("while the log is written", &mut delays);
}

#[test]
fn so_do_checked_answers() {
    let mut bench = ChipBench::booted(3);
    let mut delays = delays(&mut bench, |n| {
        let packet = packet(3, [n as u16 % 1024; 4]);
        CheckedPacket { packet, sequence: Sequence::new(n as u8 & 15) }.encode(Direction::Request)
    });
    print_delays("checked", &mut delays);
    let request = CheckedPacket { packet: packet(3, [102; 4]), sequence: Sequence::new(9) };
    let answer = bench.exchange_bytes(&request.encode(Direction::Request)).map(|answer| answer.bytes());
    let answer = CheckedPacket::decode(&answer.unwrap_or_default(), Direction::Answer);
    assert_eq!(answer, Ok(request), "at 102 counts, as commanded");
}

/// In a session every request has another CRC, which the board has to know by then.
#[test]
fn so_do_answers_in_a_session() {
    let mut bench = ChipBench::booted(3);
    let address = Address::of_board(3);
    let ping = CheckedPacket { packet: packet(3, [102; 4]), sequence: Sequence::new(9) };
    assert!(bench.exchange_bytes(&ping.encode(Direction::Request)).is_some(), "the ping");
    let asked = PageRequest::new(address, PageEntry::Session(7), Sequence::new(10));
    let answer = bench.exchange_bytes(&asked.encode()).map(|answer| answer.bytes()).unwrap_or_default();
    let mut ear = AnswerDecoder::for_page(asked, Echo::Absent);
    let heard = answer.into_iter().filter_map(|byte| ear.push(byte)).last();
    let Some(Heard::Answer(words)) = heard else { panic!("no session: {heard:?}") };
    let Some(SessionOffer::Number(number)) = SessionOffer::from_entry(words) else { panic!("{words:?}") };
    let session = Session::new(address, number);
    let mut delays = delays(&mut bench, |n| {
        let number = RequestNumber::new(n + 1);
        let packet = packet(3, [1 + n as u16 % 1000; 4]);
        CheckedPacket { packet, sequence: number.sequence() }
            .encode_sealed(Direction::Request, session.seal(number))
    });
    print_delays("in a session", &mut delays);
}

/// A host puts a byte 0x00 before a request where the byte before was 0xFF: alone, or (adapters may
/// do that) in one run with it.
#[test]
fn a_guard_byte_before_a_request_costs_nothing() {
    let mut bench = ChipBench::booted(0);
    for n in 0..200_u16 {
        // Another board's answer that ends in 0xFF.
        bench.send(&packet(1, [n, 300, 300, 511]).encode());
        let end = bench.send(&[0x00]);
        let glued = n % 2 == 0;
        if !glued {
            bench.chip.run_until(end + Ticks::from_micros(134));
        }
        let answer = bench.exchange(packet(0, [n; 4]));
        assert_on_time_and_back_to_back(&answer.unwrap_or_else(|| panic!("request {n} was not answered")));
    }
    assert_eq!(bench.chip.uart_overruns(BUS), 0);
}

#[test]
fn the_switch_sets_the_address_and_nobody_else_is_answered() {
    for own in 0..4 {
        let mut bench = ChipBench::booted(own);
        for asked in 0..=255 {
            let answer = bench.exchange(packet(asked, [511, 255, 1023, 767]));
            assert_eq!(answer.is_some(), asked == own, "board {own}, request to {asked}");
        }
    }
}

/// Four boards polled without any pause: the chip hears requests and answers of the three others
/// all the time.
#[test]
fn at_the_wires_limit_every_request_is_answered_and_no_other() {
    let mut bench = ChipBench::booted(2);
    let (mut answers, mut cycles) = (0, bench.chip.cycles());
    let from = bench.chip.now();
    for cycle in 0..500_u16 {
        for asked in 0..4 {
            let request = packet(asked, [cycle, 511, 255, 1023]).encode();
            if asked == 2 {
                let end = bench.send(&request);
                bench.chip.run_until(end + Ticks::from_micros(115));
                let spoken = bench.chip.take_transmitted(BUS).count();
                assert_eq!(spoken, 10, "cycle {cycle}");
                answers += 1;
            } else {
                let end = bench.send(&request);
                bench.chip.run_until(end + Ticks::from_micros(14));
                let end = bench.send(&packet(asked, [511, cycle, 767, 255]).encode());
                bench.chip.run_until(end + Ticks::from_micros(1));
                assert_eq!(bench.chip.take_transmitted(BUS).count(), 0, "it answered for board {asked}");
            }
        }
    }
    cycles = bench.chip.cycles() - cycles;
    let ticks = bench.chip.now().saturating_sub(from).get();
    println!("a full bus, {answers} answers: processor load {:.1} %", 100.0 * cycles as f64 / ticks as f64);
    assert_eq!(bench.chip.uart_overruns(BUS), 0);
}

#[test]
fn the_driver_is_enabled_from_before_the_first_start_bit_to_after_the_last_stop_bit() {
    let mut bench = ChipBench::booted(1);
    bench.chip.watch_pins(1 << DRIVER_ENABLE);
    for _ in 0..200 {
        let answer = bench.exchange(packet(1, [102; 4]));
        let Some(answer) = answer else { panic!("no answer") };
        let (start, end) = (answer.characters[0].start, answer.characters[9].end);
        let edges = bench.chip.take_pin_edges();
        let [on, off] = edges[..] else { panic!("{edges:?}") };
        assert_eq!((on.level, off.level), (Level::High, Level::Low));
        assert!(on.at <= start && start.saturating_sub(on.at) < Ticks::from_micros(2));
        // The host may speak a character's time after the answer has ended.
        assert!(off.at >= end && off.at.saturating_sub(end) < CHARACTER);
        bench.run(Ticks::from_micros(77));
    }
}

#[test]
fn a_lost_or_stray_byte_costs_one_request() {
    let mut bench = ChipBench::booted(0);
    let request = packet(0, [511, 255, 1023, 767]).encode();
    for lost in 0..10 {
        let mut bytes = request.to_vec();
        bytes.remove(lost);
        assert!(bench.exchange_bytes(&bytes).is_none(), "without byte {lost}");
        assert!(bench.exchange(packet(0, [102; 4])).is_some(), "after losing byte {lost}");
        bench.send(&[request[lost]]);
        bench.run(Ticks::from_micros(10 + 30));
        assert!(bench.exchange(packet(0, [102; 4])).is_some(), "after a stray 0x{:02X}", request[lost]);
    }
}

#[test]
fn an_idle_gap_starts_a_frame_and_a_shorter_pause_does_not() {
    let request = packet(0, [200; 4]).encode();
    let mut bench = ChipBench::booted(0);
    for pause_us in [0, 5, 10, 15, 20, 30, 35, 50, 100] {
        let pause = |bench: &mut ChipBench| {
            let end = bench.send(&request[..5]);
            bench.chip.run_until(end + Ticks::from_micros(pause_us));
        };
        pause(&mut bench);
        let whole = bench.exchange_bytes(&request[5..]).is_some();
        assert_eq!(whole, pause_us < 25, "a request with a pause of {pause_us} us");
        if pause_us >= 30 {
            pause(&mut bench);
            assert!(bench.exchange_bytes(&request).is_some(), "a request {pause_us} us after half of one");
        }
        bench.run(Ticks::from_micros(100));
    }
}

/// Whether a pause is a gap depends on the bytes' times, not on when the interrupt runs: the limit
/// is the same at all phases of the control loop, which holds the interrupt back.
#[test]
fn the_gap_is_found_from_the_times_of_the_bytes() {
    let request = packet(0, [200; 4]).encode();
    let mut bench = ChipBench::booted(0);
    for n in 0..2_000 {
        // From end to end 35 us of stamps, which have a resolution of 1 us, are a gap: below 34 us
        // never, from 36 us on always.
        let (pause, whole) = if n % 2 == 0 { (Ticks::new(2_985), true) } else { (Ticks::new(3_250), false) };
        let end = bench.send(&request[..5]);
        bench.chip.run_until(end + pause);
        let answered = bench.exchange_bytes(&request[5..]).is_some();
        assert_eq!(answered, whole, "request {n}, with a pause of {:.2} us", pause.as_micros());
        bench.run(Ticks::new(5_000 + n * 61 % 125_003 / 2));
    }
}

#[test]
fn a_damaged_character_costs_its_request() {
    let mut bench = ChipBench::booted(0);
    let request = packet(0, [200; 4]).encode();
    let damages = [
        LineErrors { framing: true, ..LineErrors::NONE },
        LineErrors { parity: true, ..LineErrors::NONE },
        LineErrors { framing: true, line_break: true, parity: false },
    ];
    for errors in damages {
        let mut at = bench.chip.now();
        for (position, byte) in request.into_iter().enumerate() {
            at += CHARACTER;
            bench.chip.uart_receive(BUS, at, byte, if position == 6 { errors } else { LineErrors::NONE });
        }
        bench.chip.run_until(at + Ticks::from_micros(150));
        assert_eq!(bench.chip.take_transmitted(BUS).count(), 0, "{errors:?}");
        assert!(bench.exchange(packet(0, [102; 4])).is_some());
    }
}

#[test]
fn the_answer_carries_the_pressures() {
    let mut bench = ChipBench::booted(0);
    bench.read([102, 300, 700, 921]);
    bench.run(Ticks::from_millis(100));
    let answer = bench.exchange(packet(0, [102; 4])).map(|answer| answer.packet());
    let values = [102, 300, 700, 921].map(Counts::saturating);
    assert_eq!(answer.map(|packet| (packet.address, packet.values)), Some((Address::of_board(0), values)));
}
