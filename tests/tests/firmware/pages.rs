//! Pages of the firmware, over the bus of the emulated chip.
//!
//! `cargo test -p system-tests --test firmware pages:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{
    About, ChannelNow, ChipKind, Counter, Drives, Entry, NowState, PageEntry, PostMortem, StateNow,
    StopCause, number_in,
};
use pneudrive_protocol::{
    Address, AnswerDecoder, CheckedPacket, Direction, Echo, Heard, PageRequest, Sequence,
};
use system_tests::chip_bench::{Answer, BOOT, ChipBench, packet};
use system_tests::firmware;

const MS: Ticks = Ticks::from_millis(1);
/// A host whose driver a 555 of the boards' kind enables holds the line for up to 113.6 us from its
/// first start bit.
const EARLIEST: Ticks = Ticks::new(1_700);
const LATEST: Ticks = Ticks::from_micros(20);
/// Permanently undefined: a HardFault.
const UNDEFINED: u16 = 0xDE00;

fn exchange(bench: &mut ChipBench, board: u8, entry: PageEntry, number: u8) -> (Answer, Option<Entry>) {
    let request = PageRequest::new(Address::of_board(board), entry, Sequence::new(number));
    let answer = bench.exchange_bytes(&request.encode());
    let answer = answer.unwrap_or_else(|| panic!("{entry:?} was not answered"));
    let mut decoder = AnswerDecoder::for_page(request, Echo::Absent);
    let heard = answer.bytes().into_iter().find_map(|byte| decoder.push(byte));
    let words = match heard {
        Some(Heard::Answer(words)) => Some(words),
        _ => None,
    };
    (answer, words)
}

fn ask(bench: &mut ChipBench, entry: PageEntry) -> Entry {
    exchange(bench, 0, entry, 3).1.unwrap_or_else(|| panic!("{entry:?}: something else was answered"))
}

fn counter(bench: &mut ChipBench, counter: Counter) -> u32 {
    number_in(ask(bench, PageEntry::Counter(counter))).unwrap_or_else(|| panic!("{counter:?} is no number"))
}

fn post_mortem(bench: &mut ChipBench) -> Option<PostMortem> {
    let words = std::array::from_fn(|word| {
        number_in(ask(bench, PageEntry::PostMortemWord(word as u8))).unwrap_or_else(|| panic!("word {word}"))
    });
    PostMortem::from_words(&words)
}

/// Every entry at many phases of loop and log, as soon as any answer.
#[test]
fn every_entry_is_answered_within_20_us() {
    let mut bench = ChipBench::running(2);
    let mut entries = vec![PageEntry::State, PageEntry::Drives, PageEntry::About];
    entries.extend(Counter::ALL.map(PageEntry::Counter));
    entries.extend((0..PostMortem::WORDS as u8).map(PageEntry::PostMortemWord));
    let mut delays = Vec::new();
    for n in 0..1_500_u64 {
        let entry = entries[n as usize % entries.len()];
        let (answer, words) = exchange(&mut bench, 2, entry, n as u8 & 15);
        assert!(words.is_some(), "{entry:?}");
        let late = answer.delay < EARLIEST || answer.delay > LATEST;
        assert!(!late, "{entry:?}: the answer began after {} us", answer.delay.as_micros());
        assert_eq!(answer.characters.len(), 10);
        assert!(
            answer.characters.windows(2).all(|pair| pair[0].end == pair[1].start),
            "a pause in the answer"
        );
        delays.push(answer.delay);
        bench.run(Ticks::new(n * 7 % 20_011));
    }
    delays.sort();
    let (first, last) = (delays[0].as_micros(), delays[delays.len() - 1].as_micros());
    println!("pages: from stop bit to start bit {first:.2} us at least, {last:.2} at most");
}

#[test]
fn a_board_tells_state_drives_and_what_it_is() {
    let mut bench = ChipBench::running(0);
    let now = NowState::from_entry(ask(&mut bench, PageEntry::State));
    let all = [ChannelNow::Regulating; 4];
    assert_eq!(now, Some(NowState { board: StateNow::Running, channels: all }));
    bench.read([200, 300, 400, 0]);
    assert!(bench.exchange(packet(0, [220, 290, 400, 300])).is_some());
    // The filter settles, and the broken sensor is noticed.
    for _ in 0..40 {
        bench.run(MS);
        assert!(bench.exchange(packet(0, [220, 290, 400, 300])).is_some());
    }
    let drives = Drives::from_entry(ask(&mut bench, PageEntry::Drives)).unwrap_or(Drives::new([0; 4]));
    assert_eq!(drives.counts(), [200, -100, 0, -400]);
    let coils = bench.coils();
    for (share, coil) in drives.share().into_iter().zip(coils) {
        assert!((share - coil).abs() < 0.005, "{share} is told, {coil} is at the pins");
    }
    let now = NowState::from_entry(ask(&mut bench, PageEntry::State)).map(|now| now.channels[3]);
    assert_eq!(now, Some(ChannelNow::SensorBelowRange));
    let about = About::from_entry(ask(&mut bench, PageEntry::About));
    let version = about.map(|about| about.version.map(|number| number.to_string()).join("."));
    assert_eq!(about.map(|about| about.chip), Some(ChipKind::Rp2040));
    assert_eq!(version.as_deref(), Some(env!("CARGO_PKG_VERSION")));
    assert_eq!(counter(&mut bench, Counter::SensorFaults), 1);
    assert_eq!(counter(&mut bench, Counter::LateSteps), 0);
    let (interval, took) =
        (counter(&mut bench, Counter::LongestIntervalUs), counter(&mut bench, Counter::LongestLoopUs));
    println!("longest interval {interval} us, longest loop {took} us");
    assert!((1_000..1_050).contains(&interval), "{interval} us");
    // Sixteen rounds of four readings take 128 us.
    assert!((128..400).contains(&took), "{took} us");
}

/// The command timeout runs on while only pages are read.
#[test]
fn a_host_that_only_reads_pages_is_silent() {
    let mut bench = ChipBench::filling();
    for _ in 0..2_600 {
        bench.run(MS);
        ask(&mut bench, PageEntry::Drives);
    }
    assert!(bench.drives_vent());
    let now = NowState::from_entry(ask(&mut bench, PageEntry::State)).map(|now| now.board);
    assert_eq!(now, Some(StateNow::Vent));
}

/// Read over the bus: what a HardFault left, and how often the watchdog has struck; all gone with
/// the supply.
#[test]
fn the_last_reset_is_told_to_the_host() {
    let function = firmware::address_of_function("CheckedPacket5parse");
    let mut bench = ChipBench::running(0);
    assert_eq!((post_mortem(&mut bench), counter(&mut bench, Counter::WatchdogResets)), (None, 0));
    for struck in 1..=2 {
        // A stray write to the code in RAM, which the reset's start-up copies there again.
        assert!(bench.chip.write_memory(function, &UNDEFINED.to_le_bytes()));
        let request = CheckedPacket { packet: packet(0, [500; 4]), sequence: Sequence::new(1) };
        bench.send(&request.encode(Direction::Request));
        bench.run(MS * 300);
        let record = post_mortem(&mut bench);
        let Some(PostMortem { cause: StopCause::HardFault(registers), .. }) = record else {
            panic!("{record:?}")
        };
        assert_eq!(registers.pc, function);
        assert_eq!(counter(&mut bench, Counter::WatchdogResets), struck);
    }
    bench.chip.power_cycle();
    bench.run(BOOT);
    assert_eq!((post_mortem(&mut bench), counter(&mut bench, Counter::WatchdogResets)), (None, 0));
}
