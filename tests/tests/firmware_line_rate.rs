//! The firmware at 2 and 3 Mbaud: when it answers, when it goes back, and a whole bus of chips.
//!
//! `cargo test -p system-tests --test firmware_line_rate -- --nocapture` prints the figures that docs/firmware.md and
//! docs/scaling.md state.

#![allow(clippy::unwrap_used)]

use pneudrive_chip::{Level, LineErrors, Ticks};
use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{LineRatePolicy, MissedTick, Pace, PollerOptions, Polling, SetPoints};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::pages::{
    Counter, Entry, LineRate, LineRateAnswer, LineRateState, PageEntry, RateReturn, SessionOffer, number_in,
};
use pneudrive_protocol::{
    Address, AnswerDecoder, Baud, CheckedPacket, Counts, Direction, Echo, Heard, PageRequest, RequestNumber,
    Sequence, Session,
};
use pneudrive_sim::rig::{Firmware, RigOptions};
use system_tests::chip_bench::{Answer, BUS, ChipBench, DRIVER_ENABLE, packet};
use system_tests::firmware;
use system_tests::virtual_bus::{VirtualBus, bus};

/// A host whose driver a 555 of the boards' kind enables holds the line for up to 113.6 us from its first start bit.
const EARLIEST: Ticks = Ticks::new(1_700);
const LATEST: Ticks = Ticks::from_micros(20);
const MS: Ticks = Ticks::from_millis(1);

/// A bench, and a host in a session with its board.
#[derive(Clone)]
struct Host {
    bench: ChipBench,
    board: u8,
    session: Option<(Session, RequestNumber)>,
}

impl Host {
    fn in_session(bench: ChipBench, board: u8) -> Self {
        let mut host = Self { bench, board, session: None };
        match SessionOffer::from_entry(host.ask(PageEntry::Session(3)).unwrap()) {
            Some(SessionOffer::Number(number)) => {
                let session = Session::new(Address::of_board(board), number);
                host.session = Some((session, RequestNumber::default()));
            }
            other => panic!("{other:?}"),
        }
        host.command([102; 4]).unwrap();
        host
    }

    /// At this rate.
    fn at(rate: LineRate, board: u8) -> Self {
        let mut host = Self::in_session(ChipBench::running(board), board);
        host.go_to(rate);
        host
    }

    fn go_to(&mut self, rate: LineRate) {
        let answer = self.ask(PageEntry::SetLineRate(rate)).unwrap();
        assert_eq!(LineRateAnswer::from_entry(answer), Some(LineRateAnswer::Taken));
        // The answer, and the change.
        self.bench.run(Ticks::from_micros(100));
        self.bench.baud = rate.baud(Baud::ORIGINAL);
    }

    fn command(&mut self, commands: [u16; 4]) -> Option<Answer> {
        let bytes = self.command_bytes(commands);
        self.bench.exchange_bytes(&bytes)
    }

    fn command_bytes(&mut self, commands: [u16; 4]) -> [u8; 10] {
        let (session, number) = self.session.as_mut().unwrap();
        *number = number.next();
        let checked = CheckedPacket { packet: packet(self.board, commands), sequence: number.sequence() };
        checked.encode_sealed(Direction::Request, session.seal(*number))
    }

    fn ask(&mut self, entry: PageEntry) -> Option<Entry> {
        let plain = PageRequest::new(Address::of_board(self.board), entry, Sequence::new(3));
        let request = match &mut self.session {
            None => plain,
            Some((session, number)) => {
                *number = number.next();
                plain.sealed(session.seal(*number))
            }
        };
        let answer = self.bench.exchange_bytes(&request.encode())?;
        let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
        match answer.bytes().into_iter().find_map(|byte| decoder.push(byte)) {
            Some(Heard::Answer(words)) => Some(words),
            other => panic!("{entry:?}: {other:?}"),
        }
    }

    fn counter(&mut self, counter: Counter) -> u32 {
        number_in(self.ask(PageEntry::Counter(counter)).unwrap()).unwrap()
    }

    fn rate_on_the_chip(&self) -> u64 {
        self.bench.chip.uart_baud(BUS)
    }
}

fn is_near(rate: u64, wanted: u64) -> bool {
    rate.abs_diff(wanted) * 200 <= wanted
}

fn report(name: &str, delays: &mut [Ticks]) {
    delays.sort();
    let at = |part: usize| delays[(delays.len() - 1) * part / 1_000].as_micros();
    println!(
        "{name}: from stop bit to start bit {:.2} us at least, {:.2} median, {:.2} 99th percentile, {:.2} at most",
        at(0),
        at(500),
        at(990),
        at(1_000)
    );
}

/// Exchanges in a session at every phase of the control loop and of the log.
#[test]
fn answers_are_as_prompt_as_at_1_mbaud_and_go_out_back_to_back() {
    for rate in [LineRate::TwoMbaud, LineRate::ThreeMbaud] {
        let mut host = Host::at(rate, 3);
        let baud = u64::from(rate.baud(Baud::ORIGINAL).get());
        assert!(is_near(host.rate_on_the_chip(), baud), "{} baud", host.rate_on_the_chip());
        let mut delays = Vec::new();
        for n in 0..3_000_u64 {
            let entry = [PageEntry::State, PageEntry::LineRate, PageEntry::Drives][n as usize % 3];
            if n % 10 == 0 {
                assert!(host.ask(entry).is_some(), "{entry:?}");
            }
            let answer = host.command([1 + n as u16 % 1_000; 4]).unwrap_or_else(|| panic!("request {n}"));
            assert!(answer.delay >= EARLIEST && answer.delay <= LATEST, "{} us", answer.delay.as_micros());
            assert_eq!(answer.characters.len(), 10);
            assert!(answer.characters.windows(2).all(|pair| pair[0].end == pair[1].start), "a pause");
            let spoken = answer.characters[9].end.saturating_sub(answer.characters[0].start);
            assert!(is_near(spoken.get() * baud, 100 * Ticks::PER_SECOND), "{} us", spoken.as_micros());
            delays.push(answer.delay);
            host.bench.run(Ticks::new(n * 7 % 20_011));
        }
        report(&format!("{rate:?}, in a session"), &mut delays);
        assert_eq!(host.bench.chip.uart_overruns(BUS), 0);
        assert_eq!(host.counter(Counter::DamagedRequests), 0);
        let unmodelled: Vec<_> = host.bench.chip.unmodelled_accesses().collect();
        assert!(unmodelled.is_empty(), "{unmodelled:?}");
    }
}

#[test]
fn the_driver_is_enabled_for_the_shorter_answer_only() {
    let mut host = Host::at(LineRate::ThreeMbaud, 1);
    host.bench.chip.watch_pins(1 << DRIVER_ENABLE);
    let character = Ticks::new(Baud::THREE_MBAUD.characters_ns(1) * Ticks::PER_SECOND / 1_000_000_000);
    for _ in 0..200 {
        let answer = host.command([102; 4]).unwrap();
        let (start, end) = (answer.characters[0].start, answer.characters[9].end);
        let edges = host.bench.chip.take_pin_edges();
        let [on, off] = edges[..] else { panic!("{edges:?}") };
        assert_eq!((on.level, off.level), (Level::High, Level::Low));
        assert!(on.at <= start && start.saturating_sub(on.at) < Ticks::from_micros(2));
        // The host may speak a character's time after the answer has ended.
        assert!(off.at >= end && off.at.saturating_sub(end) < character);
        host.bench.run(Ticks::from_micros(77));
    }
}

/// A board that hears its own answers (its receiver stays enabled) takes none for a request, and none of the next request for an answer.
#[test]
fn a_board_that_hears_itself_answers_what_follows_at_once() {
    let mut host = Host::at(LineRate::ThreeMbaud, 0);
    for n in 0..500_u64 {
        let request = host.command_bytes([511; 4]);
        let end = host.bench.send(&request);
        let _ = host.bench.chip.take_transmitted(BUS).count();
        let mut heard = 0;
        let mut answered = end;
        while heard < 10 {
            host.bench.chip.run_until(host.bench.chip.now() + Ticks::new(20));
            for character in host.bench.chip.take_transmitted(BUS).collect::<Vec<_>>() {
                host.bench.chip.uart_receive(BUS, character.end, character.byte, LineErrors::NONE);
                (heard, answered) = (heard + 1, character.end);
            }
            assert!(host.bench.chip.now() < end + Ticks::from_micros(100), "request {n}: {heard} bytes");
        }
        // The next request 3 to 13 us after the answer's last stop bit.
        host.bench.chip.run_until(answered + Ticks::from_micros(3) + Ticks::new(n * 37 % 1_250));
    }
    assert_eq!(host.counter(Counter::DamagedRequests), 0);
}

/// To the millisecond, at every phase of the control loop; then the board answers at 1 Mbaud and says why.
#[test]
fn a_board_that_hears_no_request_goes_back_after_100_ms() {
    let mut host = Host::at(LineRate::ThreeMbaud, 2);
    for n in 0..8_u64 {
        let start = host.bench.chip.now();
        assert!(host.command([300; 4]).is_some());
        let heard = host.bench.chip.now().saturating_sub(start);
        host.bench.run(Ticks::from_micros(99_500 - 200) - heard);
        assert!(is_near(host.rate_on_the_chip(), 3_000_000));
        host.bench.run(Ticks::from_micros(1_900));
        assert!(is_near(host.rate_on_the_chip(), 1_000_000), "after 101 ms");
        host.bench.baud = Baud::ORIGINAL;
        let state = LineRateState::from_entry(host.ask(PageEntry::LineRate).unwrap()).unwrap();
        assert_eq!((state.returns, state.last_return), (n as u16 + 1, Some(RateReturn::Silence)));
        assert!(host.command([300; 4]).is_some());
        host.bench.run(Ticks::new(n * 17_001));
        host.go_to(LineRate::ThreeMbaud);
    }
}

#[test]
fn damage_sends_a_board_back_before_it_vents() {
    let mut host = Host::at(LineRate::ThreeMbaud, 0);
    assert!(host.command([300; 4]).is_some());
    let mut damages = 0;
    while is_near(host.rate_on_the_chip(), 3_000_000) {
        let at = host.bench.chip.now() + Ticks::from_micros(200);
        host.bench.chip.uart_receive(BUS, at, 0x55, LineErrors { framing: true, ..LineErrors::NONE });
        damages += 1;
        // A control step at least.
        host.bench.run(MS + Ticks::from_micros(300));
        assert!(damages < 40, "after {damages} damaged bytes");
        if is_near(host.rate_on_the_chip(), 3_000_000) {
            assert!(host.command([300; 4]).is_some());
        }
        host.bench.run(MS);
    }
    assert_eq!(damages, 25);
    host.bench.baud = Baud::ORIGINAL;
    let state = LineRateState::from_entry(host.ask(PageEntry::LineRate).unwrap()).unwrap();
    assert_eq!((state.now, state.last_return), (LineRate::Compiled, Some(RateReturn::Damage)));
}

/// Four boards as one of them hears it: answers as prompt as ever, nothing lost, and the control loop in step. At 2 kHz, and without any pause
/// between an answer and the next request.
#[test]
fn a_chip_on_a_bus_of_four_at_3_mbaud_has_time_for_everything() {
    four_boards("at 2 kHz", 15_600);
    four_boards("at the wire's limit", 0);
}

/// `slot`: ticks from request to request, if there is more time than they take.
fn four_boards(name: &str, slot: u64) {
    let mut host = Host::at(LineRate::ThreeMbaud, 2);
    let (from, cycles) = (host.bench.chip.now(), host.bench.chip.cycles());
    let mut delays = Vec::new();
    for cycle in 0..4_000_u64 {
        for asked in 0..4 {
            let due = from + Ticks::new((4 * cycle + asked) * slot + cycle % 50 * slot.min(1));
            if due > host.bench.chip.now() {
                host.bench.chip.run_until(due);
            }
            if asked == 2 {
                let answer = {
                    let bytes = host.command_bytes([300; 4]);
                    let end = host.bench.send(&bytes);
                    // 33.4 us of answer.
                    host.bench.chip.run_until(end + Ticks::from_micros(if slot > 0 { 60 } else { 53 }));
                    let spoken: Vec<_> = host.bench.chip.take_transmitted(BUS).collect();
                    assert_eq!(spoken.len(), 10, "cycle {cycle}");
                    spoken[0].start.saturating_sub(end)
                };
                assert!(answer >= EARLIEST && answer <= LATEST, "cycle {cycle}: {} us", answer.as_micros());
                delays.push(answer);
            } else {
                // Of a session that this board does not know.
                let session = Session::new(Address::of_board(asked as u8), 99);
                let number = RequestNumber::new(cycle as u32);
                let say = |direction| {
                    let packet = packet(asked as u8, [cycle as u16 % 1_024; 4]);
                    CheckedPacket { packet, sequence: number.sequence() }
                        .encode_sealed(direction, session.seal(number))
                };
                let end = host.bench.send(&say(Direction::Request));
                host.bench.chip.run_until(end + Ticks::from_micros(17));
                let end = host.bench.send(&say(Direction::Answer));
                host.bench.chip.run_until(end);
            }
        }
    }
    let ticks = host.bench.chip.now().saturating_sub(from).get();
    let load = 100.0 * (host.bench.chip.cycles() - cycles) as f64 / ticks as f64;
    report(&format!("four boards at 3 Mbaud {name}"), &mut delays);
    println!("processor load {load:.1} %");
    assert_eq!(host.bench.chip.uart_overruns(BUS), 0);
    let (late, longest) = (host.counter(Counter::LateSteps), host.counter(Counter::LongestIntervalUs));
    println!("control loop: {late} late steps, longest interval {longest} us");
    assert_eq!(late, 0);
}

fn chips(boards: usize) -> RigOptions {
    RigOptions {
        boards,
        firmware: Some(Firmware::new(firmware::elf())),
        strict: true,
        ..RigOptions::default()
    }
}

/// Chips polled for so long at up to `fastest`; the statistics of the time after the first half second, in which rates are agreed on.
fn poll(boards: u16, fastest: LineRate, pace: Pace, seconds: f64) -> (Statistics, Polling<VirtualBus>) {
    let points = SetPoints::new(usize::from(boards));
    let line_rate = LineRatePolicy { fastest, ..LineRatePolicy::default() };
    let options = PollerOptions {
        pace,
        line_rate: Some(line_rate).filter(|_| fastest != LineRate::Compiled),
        ..PollerOptions::for_devices(boards)
    };
    let mut bus = bus(&chips(usize::from(boards)), BusOptions::default());
    // So that what is measured begins at the rate.
    for board in 0..boards as u8 {
        bus.ping(board).unwrap();
    }
    let run = |bus: Bus<VirtualBus>, options: PollerOptions, points: &SetPoints, seconds: f64| {
        let mut polling = Polling::new(bus, options, Box::new(points.clone()), Vec::new());
        let end_ns = polling.bus_mut().line().now_ns() + (seconds * 1e9) as u64;
        while polling.bus_mut().line().now_ns() < end_ns {
            let due_ns = polling.next_cycle_ns();
            polling.bus_mut().line_mut().sleep_until(due_ns);
            polling.cycle().unwrap();
        }
        polling
    };
    let polling = run(bus, options.clone(), &points, 0.2);
    for board in 0..usize::from(boards) {
        points.set(board, [Counts::saturating(250); 4]).unwrap();
    }
    let mut polling = run(polling.into_bus(), options, &points, seconds);
    (polling.finish(), polling)
}

/// Four emulated chips at 3 Mbaud, 2 kHz, checked packets in sessions, nothing lost.
#[test]
fn four_chips_at_3_mbaud_are_polled_at_2_khz_without_a_loss() {
    let pace = Pace::Every { period_ns: 500_000, missed: MissedTick::Skip };
    let (statistics, mut polling) = poll(4, LineRate::ThreeMbaud, pace, 4.0);
    assert_eq!(statistics.baud, Some(3_000_000));
    assert!((statistics.loop_hz.mean - 2_000.0).abs() < 1.0, "{statistics:?}");
    assert_eq!((statistics.lost, statistics.rejected, statistics.missed_ticks), (0, 0, 0), "{statistics:?}");
    assert!(statistics.exchanges >= 31_990, "{statistics:?}");
    for board in 0..4 {
        assert!(polling.bus_mut().in_session(board));
        assert_eq!(polling.bus_mut().counter(board, Counter::LateSteps), Ok(0));
        assert_eq!(polling.bus_mut().counter(board, Counter::DamagedRequests), Ok(0));
    }
    assert_eq!(polling.bus_mut().line().counters().violations(), 0);
}

/// The table of docs/scaling.md: as fast as possible, in virtual time, so that the boards' turnaround is all that is added to the wire.
#[test]
fn a_table_of_rates() {
    println!("| boards | 1 Mbaud: wire's limit, measured | 2 Mbaud | 3 Mbaud |\n| --- | --- | --- | --- |");
    for boards in 1..=4 {
        let cells = LineRate::ALL.map(|rate| {
            let baud = rate.baud(Baud::ORIGINAL);
            let (statistics, _) = poll(boards, rate, Pace::AsFastAsPossible, 1.0);
            assert_eq!(statistics.baud, Some(baud.get()));
            assert_eq!((statistics.lost, statistics.rejected), (0, 0), "{statistics:?}");
            let limit = baud.cycle_limit_hz(boards.into());
            // At most 20 us of turnaround, and 0.2 % by which a chip's divisors miss 3 Mbaud.
            let slowest = 1e9 / (f64::from(boards) * (baud.exchange_ns() as f64 * 1.002 + 20_000.0));
            let mean = statistics.loop_hz.mean;
            assert!(mean < limit && mean > slowest, "{mean} Hz, wire {limit} Hz, slowest {slowest} Hz");
            format!("{limit:.0}, {mean:.0}")
        });
        println!("| {boards} | {} |", cells.join(" | "));
    }
}
