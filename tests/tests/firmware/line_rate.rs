//! The firmware at 2 and 3 Mbaud: when it answers, and when it goes back.
//!
//! `cargo test -p system-tests --test firmware line_rate:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

use pneudrive_chip::{Level, LineErrors, Ticks};
use pneudrive_protocol::pages::{
    Change, ChangeAnswer, Counter, Entry, LineRate, LineRateAnswer, LineRateState, PageEntry, Parameter,
    RateReturn, number_in,
};
use pneudrive_protocol::{Address, Baud, CheckedPacket, Direction, RequestNumber, Session};
use system_tests::chip_bench::{Answer, BOOT, BUS, ChipBench, DRIVER_ENABLE, packet, print_delays};
use system_tests::session_host::{SessionHost, words_of};

/// A host whose driver a 555 of the boards' kind enables holds the line for up to 113.6 us from its
/// first start bit.
const EARLIEST: Ticks = Ticks::new(1_700);
const LATEST: Ticks = Ticks::from_micros(20);
const MS: Ticks = Ticks::from_millis(1);

/// A bench, and a host in a session with its board.
#[derive(Clone)]
struct Host {
    bench: ChipBench,
    host: SessionHost,
}

impl Host {
    fn in_session(bench: ChipBench, board: u8) -> Self {
        let mut host = Self { bench, host: SessionHost::new(board) };
        let offer = host.ask(PageEntry::Session(3)).unwrap();
        host.host.begin(offer);
        host.command([102; 4]).unwrap();
        host
    }

    /// At this rate.
    fn at(rate: LineRate, board: u8) -> Self {
        Self::of(ChipBench::running(board), rate, board)
    }

    fn of(bench: ChipBench, rate: LineRate, board: u8) -> Self {
        let mut host = Self::in_session(bench, board);
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
        self.host.command(commands)
    }

    fn ask(&mut self, entry: PageEntry) -> Option<Entry> {
        let request = self.host.request(entry);
        let answer = self.bench.exchange_bytes(&request.encode())?;
        Some(words_of(request, &answer))
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
        print_delays(&format!("{rate:?}, in a session"), &mut delays);
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

/// A board that hears its own answers (its receiver stays enabled) takes none for a request, and
/// none of the next request for an answer.
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

/// To the millisecond, at every phase of the control loop; then the board answers at 1 Mbaud and
/// says why.
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

/// Four boards as one of them hears it: answers as prompt as ever, nothing lost, and the control
/// loop in step. At 2 kHz, and without any pause between an answer and the next request.
#[test]
fn a_chip_on_a_bus_of_four_at_3_mbaud_has_time_for_everything() {
    four_boards("at 2 kHz", 15_600, ChipBench::running(2), 1_000);
    four_boards("at the wire's limit", 0, ChipBench::running(2), 1_000);
}

/// The same with a control loop of 2 kHz, which a host has set.
#[test]
fn so_has_one_whose_control_loop_runs_at_2_khz() {
    let mut host = Host::in_session(ChipBench::running(2), 2);
    let changes = Parameter::LOOP_2_KHZ.map(|(parameter, value)| Change::Set(parameter, value));
    for change in [Change::Begin].into_iter().chain(changes).chain([Change::Commit]) {
        let answer = ChangeAnswer::from_entry(host.ask(PageEntry::Change(change)).unwrap());
        assert_eq!(answer, Some(ChangeAnswer::Taken), "{change:?}");
    }
    let mut bench = host.bench;
    bench.run(MS * 70 + BOOT + MS * 2_000);
    four_boards("at 2 kHz, loop of 2 kHz", 15_600, bench, 2_000);
}

/// `slot`: ticks from request to request, if there is more time than they take.
fn four_boards(name: &str, slot: u64, bench: ChipBench, loop_hz: u32) {
    let mut host = Host::of(bench, LineRate::ThreeMbaud, 2);
    let steps = host.counter(Counter::Steps);
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
    print_delays(&format!("four boards at 3 Mbaud {name}"), &mut delays);
    println!("processor load {load:.1} %");
    assert_eq!(host.bench.chip.uart_overruns(BUS), 0);
    let (late, longest) = (host.counter(Counter::LateSteps), host.counter(Counter::LongestIntervalUs));
    println!("control loop: {late} late steps, longest interval {longest} us");
    assert_eq!(late, 0);
    let made = u64::from(host.counter(Counter::Steps) - steps);
    assert!(
        (made * Ticks::PER_SECOND).abs_diff(ticks * u64::from(loop_hz)) < 3 * Ticks::PER_SECOND,
        "{made} steps"
    );
}
