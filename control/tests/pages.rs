//! Page requests: what a board answers, and what they leave as it is.

use crate::common;
use crate::common::{Bench, packet};
use pneudrive_control::{AdcSample, BoardConfig, BoardState, Identity, Micros};
use pneudrive_protocol::pages::{
    About, ChannelNow, ChipKind, Counter, Drives, Entry, NO_SUCH_ENTRY, NowState, PageEntry, PostMortem,
    StateNow, StopCause, number_in,
};
use pneudrive_protocol::{AnswerDecoder, Echo, Heard, PageRequest, Sequence};

/// Asks, and gives the words of the answer.
fn ask(bench: &mut Bench, entry: PageEntry) -> Option<Entry> {
    let request = PageRequest::new(bench.board.address(), entry, Sequence::new(7));
    let answers = bench.raw_bytes(&request.encode());
    bench.wait_us(150);
    let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
    match answers.concat().into_iter().find_map(|byte| decoder.push(byte))? {
        Heard::Answer(words) => Some(words),
        Heard::Other(other) => panic!("{other:?}"),
    }
}

fn counter(bench: &mut Bench, counter: Counter) -> u32 {
    number_in(ask(bench, PageEntry::Counter(counter)).unwrap()).unwrap()
}

#[test]
fn state_and_drives_are_those_of_the_last_control_step() {
    let config =
        BoardConfig { filter_previous: 0, enabled: [true, true, true, false], ..BoardConfig::default() };
    let mut bench = Bench::new(config, 2);
    assert_eq!(ask(&mut bench, PageEntry::State), None, "before the first control step nothing is known");
    bench.step();
    let state = |bench: &mut Bench| NowState::from_entry(ask(bench, PageEntry::State).unwrap()).unwrap();
    let drives = |bench: &mut Bench| Drives::from_entry(ask(bench, PageEntry::Drives).unwrap()).unwrap();
    assert_eq!((state(&mut bench).board, drives(&mut bench).counts()), (StateNow::PowerUpVent, [-400; 4]));
    bench.steps(2_000);
    bench.request([103, 112, 92, 500]).unwrap();
    let shown = bench.step();
    let now = state(&mut bench);
    use ChannelNow::{Disabled, Regulating, SensorBelowRange};
    assert_eq!(
        (now.board, now.channels),
        (StateNow::Running, [Regulating, Regulating, Regulating, Disabled])
    );
    assert_eq!((shown, drives(&mut bench).counts()), ([10, 100, -100, -400], [10, 100, -100, -400]));
    bench.samples[1] = AdcSample::from_reading(0);
    bench.steps(10);
    assert_eq!(state(&mut bench).channels[1], SensorBelowRange);
    assert_eq!(counter(&mut bench, Counter::SensorFaults), 1);
}

/// The command timeout runs on, and the commands stay.
#[test]
fn a_host_that_only_reads_pages_is_silent() {
    let mut bench = Bench::running();
    bench.request([300; 4]).unwrap();
    for _ in 0..3_000 {
        bench.step();
        assert!(ask(&mut bench, PageEntry::Drives).is_some());
    }
    let status = bench.board.status();
    assert_eq!((status.state, status.commands), (BoardState::Vent, [common::counts(300); 4]));
    assert_eq!(counter(&mut bench, Counter::CommandTimeouts), 1);
}

/// A board that nobody has commanded in checked packets still obeys an original host.
#[test]
fn who_reads_pages_commands_nothing() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    bench.step();
    assert!(ask(&mut bench, PageEntry::About).is_some());
    assert!(bench.request([300; 4]).is_some());
    assert_eq!(bench.board.status().counters.requests, 1);
    assert_eq!(bench.board.status().counters.page_requests, 1);
}

#[test]
fn counters_say_what_has_happened() {
    let mut bench = Bench::new(BoardConfig::default(), 0);
    bench.step();
    bench.request([102; 4]).unwrap();
    bench.bytes(&packet(3, [102; 4]).encode());
    bench.board.line_error(Micros::new(bench.now_us));
    bench.wait_us(1_500);
    bench.step();
    bench.wait_us(3_000_000);
    let expected = [
        (Counter::Requests, 1),
        (Counter::Answers, 1),
        (Counter::PageRequests, 3),
        (Counter::LineErrors, 1),
        // Two of others' and the five page requests so far.
        (Counter::Packets, 7),
        (Counter::DiscardedBytes, 0),
        (Counter::Steps, 2),
        (Counter::LateSteps, 1),
        (Counter::LongestLoopUs, 0),
        (Counter::CommandTimeouts, 0),
        (Counter::UptimeS, 3),
        (Counter::WatchdogResets, 0),
    ];
    for (which, value) in expected {
        assert_eq!(counter(&mut bench, which), value, "{which:?}");
    }
    // A period, 100 us of each of two packets, the pause behind an answer, and the wait.
    assert_eq!(counter(&mut bench, Counter::LongestIntervalUs), 1_000 + 250 + 100 + 1_500);
}

#[test]
fn a_board_says_what_it_is_and_why_it_was_reset() {
    let bench = Bench::new(BoardConfig::default(), 1);
    let (mut port, mut control) = bench.board.split();
    let record = PostMortem { cause: StopCause::panic("src/bus.rs", 42), at_us: 77 };
    port.identify(Identity {
        watchdog_resets: 3,
        post_mortem: record.to_words(),
        ..Identity::of_chip(ChipKind::Rp2350)
    });
    port.loop_took(Micros::new(180));
    port.loop_took(Micros::new(170));
    let step = control.step(Micros::new(1), [AdcSample::from_reading(408); 4], port.orders());
    port.report(step.report);
    let mut now_us = 1_000;
    let mut ask = |entry: PageEntry| -> Entry {
        let request = PageRequest::new(port.address(), entry, Sequence::new(1));
        now_us += 1_000;
        let mut heard =
            request.encode().into_iter().filter_map(|byte| port.receive_byte(Micros::new(now_us), byte));
        let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
        match heard.next().unwrap().into_iter().find_map(|byte| decoder.push(byte)) {
            Some(Heard::Answer(words)) => words,
            other => panic!("{other:?}"),
        }
    };
    let about = About::from_entry(ask(PageEntry::About)).unwrap();
    let ours = env!("CARGO_PKG_VERSION");
    assert_eq!(
        (about.chip, about.version.map(|n| n.to_string()).join(".")),
        (ChipKind::Rp2350, ours.to_owned())
    );
    assert_eq!(number_in(ask(PageEntry::Counter(Counter::WatchdogResets))), Some(3));
    assert_eq!(number_in(ask(PageEntry::Counter(Counter::LongestLoopUs))), Some(180));
    let words = std::array::from_fn(|word| number_in(ask(PageEntry::PostMortemWord(word as u8))).unwrap());
    assert_eq!(PostMortem::from_words(&words), Some(record));
    assert_ne!(ask(PageEntry::State), NO_SUCH_ENTRY);
}
