//! Parameters over the bus of the emulated chip: when they are taken, and what a power cut does to
//! them in flash.
//!
//! `cargo test -p system-tests --test firmware parameters:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

use pneudrive_chip::{ResetReason, Ticks};
use pneudrive_protocol::pages::{
    Change, ChangeAnswer, CommitOutcome, Counter, Entry, PageEntry, Parameter, ParameterSource, StoreState,
    number_in,
};
use system_tests::chip_bench::{Answer, BOOT, ChipBench};
use system_tests::session_host::{SessionHost, words_of};

const MS: Ticks = Ticks::from_millis(1);
const LATEST: Ticks = Ticks::from_micros(20);

/// A bench, and a host in a session with its board.
#[derive(Clone)]
struct Host {
    bench: ChipBench,
    host: SessionHost,
    slowest: Ticks,
}

impl Host {
    fn new(bench: ChipBench, board: u8) -> Self {
        Self { bench, host: SessionHost::new(board), slowest: Ticks::ZERO }
    }

    /// At a board that runs and has been commanded 0 kPa in a session.
    fn in_session(bench: ChipBench, board: u8) -> Self {
        let mut host = Self::new(bench, board);
        let offer = host.ask(PageEntry::Session(3));
        host.host.begin(offer);
        host.command([102; 4]);
        host
    }

    fn note(&mut self, answer: &Answer) {
        assert!(answer.delay <= LATEST, "the answer began after {} us", answer.delay.as_micros());
        self.slowest = self.slowest.max(answer.delay);
    }

    fn command(&mut self, commands: [u16; 4]) {
        let bytes = self.host.command(commands);
        let answer = self.bench.exchange_bytes(&bytes).unwrap_or_else(|| panic!("{commands:?}: no answer"));
        self.note(&answer);
    }

    fn try_ask(&mut self, entry: PageEntry) -> Option<Entry> {
        let request = self.host.request(entry);
        let answer = self.bench.exchange_bytes(&request.encode())?;
        self.note(&answer);
        Some(words_of(request, &answer))
    }

    fn ask(&mut self, entry: PageEntry) -> Entry {
        self.try_ask(entry).unwrap_or_else(|| panic!("{entry:?} was not answered"))
    }

    fn change(&mut self, change: Change) -> Option<ChangeAnswer> {
        ChangeAnswer::from_entry(self.ask(PageEntry::Change(change)))
    }

    fn value(&mut self, parameter: Parameter) -> Option<u32> {
        number_in(self.ask(PageEntry::Parameter(parameter)))
    }

    fn store(&mut self) -> StoreState {
        let words = self.ask(PageEntry::Store);
        StoreState::from_entry(words).unwrap_or_else(|| panic!("{words:?}"))
    }

    fn collect(&mut self, from: Change, changes: &[(Parameter, u32)]) {
        assert_eq!(self.change(from), Some(ChangeAnswer::Taken));
        for (parameter, value) in changes {
            assert_eq!(self.change(Change::Set(*parameter, *value)), Some(ChangeAnswer::Taken));
        }
    }

    /// Commits; the board restarts, and is then at `board`.
    fn commit(mut self, board: u8) -> Self {
        assert_eq!(self.change(Change::Commit), Some(ChangeAnswer::Taken));
        let resets = self.bench.chip.resets().len();
        self.bench.run(MS * 70);
        assert_eq!(self.bench.chip.resets().len(), resets + 1, "it restarts");
        assert_eq!(
            self.bench.chip.resets().last().map(|reset| reset.reason),
            Some(ResetReason::WatchdogForce)
        );
        self.bench.run(BOOT);
        Self::new(self.bench, board)
    }
}

/// Set, kept over a power cycle, and reset; with another address, which the switch has again
/// afterwards.
#[test]
fn parameters_are_kept_and_go_back_to_those_compiled() {
    let mut host = Host::in_session(ChipBench::running(1), 1);
    assert_eq!(host.value(Parameter::Kp), Some(10));
    assert_eq!(host.value(Parameter::Address), Some(256));
    host.collect(
        Change::Begin,
        &[(Parameter::Kp, 33), (Parameter::HoldTime, 60_000), (Parameter::Address, 9)],
    );
    assert_eq!(host.value(Parameter::Kp), Some(10), "not before it is committed");
    let mut host = host.commit(9);
    for _ in 0..2 {
        assert_eq!(host.value(Parameter::Kp), Some(33));
        assert_eq!(host.value(Parameter::HoldTime), Some(60_000));
        assert_eq!(number_in(host.ask(PageEntry::Compiled(Parameter::Kp))), Some(10));
        let state = StoreState { outcome: CommitOutcome::None, source: ParameterSource::Stored, record: 1 };
        assert_eq!(host.store(), state);
        host.bench.chip.power_cycle();
        host.bench.run(BOOT);
    }
    let watchdog = PageEntry::Counter(Counter::WatchdogResets);
    assert_eq!(number_in(host.ask(watchdog)), Some(0), "the restart is no failure");
    host.bench.run(MS * 2_000);
    let mut host = Host::in_session(host.bench, 9);
    host.collect(Change::BeginFromDefaults, &[]);
    let mut host = host.commit(1);
    assert_eq!((host.value(Parameter::Kp), host.value(Parameter::Address)), (Some(10), Some(256)));
    assert_eq!(host.store().source, ParameterSource::Compiled);
    let unmodelled: Vec<_> = host.bench.chip.unmodelled_accesses().collect();
    assert!(unmodelled.is_empty(), "{unmodelled:?}");
}

/// Every kind of change and question at many phases of loop and log, as soon as any answer.
#[test]
fn changes_are_answered_within_20_us() {
    let mut host = Host::in_session(ChipBench::running(2), 2);
    let mut entries = vec![
        PageEntry::Change(Change::Begin),
        PageEntry::Change(Change::BeginFromDefaults),
        PageEntry::Store,
    ];
    entries.extend(Parameter::ALL.map(PageEntry::Parameter));
    entries.extend(Parameter::ALL.map(PageEntry::Compiled));
    entries.extend(Parameter::ALL.map(|parameter| PageEntry::Change(Change::Set(parameter, 104_039))));
    for n in 0..1_200_u64 {
        host.ask(entries[n as usize % entries.len()]);
        host.command([102; 4]);
        host.bench.run(Ticks::new(n * 7 % 20_011));
    }
    println!(
        "in a session, with changes: from stop bit to start bit {:.2} us at most",
        host.slowest.as_micros()
    );
}

/// Every refusal, and that nothing is written or restarted for it.
#[test]
fn what_must_not_be_is_refused() {
    let mut host = Host::new(ChipBench::running(0), 0);
    assert_eq!(host.change(Change::Begin), Some(ChangeAnswer::NeedsSession));
    let mut host = Host::in_session(host.bench, 0);
    assert_eq!(host.change(Change::Commit), Some(ChangeAnswer::NotBegun));
    assert_eq!(host.change(Change::Begin), Some(ChangeAnswer::Taken));
    let outcome = |host: &mut Host| {
        assert_eq!(host.change(Change::Commit), Some(ChangeAnswer::Taken));
        host.bench.run(MS * 30);
        host.store().outcome
    };
    assert_eq!(outcome(&mut host), CommitOutcome::Unchanged);
    for (parameter, value) in [(Parameter::Kp, 0), (Parameter::Kp, 1_001), (Parameter::LoopPeriod, 10_001)] {
        host.collect(Change::Begin, &[(parameter, value)]);
        assert_eq!(outcome(&mut host), CommitOutcome::Refused(parameter));
    }
    host.collect(Change::Begin, &[(Parameter::SensorMargin, 103)]);
    assert_eq!(outcome(&mut host), CommitOutcome::Refused(Parameter::SensorMin));
    host.collect(Change::Begin, &[(Parameter::Kp, 11)]);
    host.command([103, 102, 102, 102]);
    assert_eq!(outcome(&mut host), CommitOutcome::NotVented, "a set point above 0 kPa");
    host.collect(Change::Begin, &[(Parameter::Kp, 11)]);
    host.command([102; 4]);
    host.bench.read([102, 102, 102, 140]);
    host.bench.run(MS * 60);
    assert_eq!(outcome(&mut host), CommitOutcome::NotVented, "pressure in a chamber");
    assert_eq!(host.bench.chip.resets().len(), 1);
    assert_eq!(host.bench.chip.flash_busy_until(), Ticks::ZERO, "nothing was written");
}

/// The supply ends at 64 moments of the erase and 64 of the program: the board starts with the old
/// parameters or with the new ones.
#[test]
fn a_power_cut_at_any_moment_leaves_the_old_or_the_new() {
    // Both slots are full, so that the erase has something to do.
    let mut bench = ChipBench::running(0);
    for kp in [21, 22] {
        let mut host = Host::in_session(bench, 0);
        host.collect(Change::Begin, &[(Parameter::Kp, kp)]);
        bench = host.commit(0).bench;
        bench.run(MS * 2_000);
    }
    let mut host = Host::in_session(bench, 0);
    host.collect(Change::Begin, &[(Parameter::Kp, 23), (Parameter::HoldTime, 12_345)]);
    assert_eq!(host.change(Change::Commit), Some(ChangeAnswer::Taken));

    let (mut old, mut new) = (0, 0);
    let mut changes = Vec::new();
    for _ in 0..2 {
        let before = host.bench.chip.flash_busy_until();
        host.bench.run_until_seen(MS * 60, |bench| bench.chip.flash_busy_until() > before);
        let (begin, end) = (host.bench.chip.now(), host.bench.chip.flash_busy_until());
        let takes = end.saturating_sub(begin);
        changes.push(takes.as_micros());
        for part in 0..=64 {
            let mut cut = host.clone();
            cut.host = SessionHost::new(cut.host.board);
            cut.bench.chip.run_until(begin + Ticks::new(takes.get() * part / 64));
            cut.bench.chip.power_cycle();
            cut.bench.run(BOOT);
            match (cut.value(Parameter::Kp), cut.value(Parameter::HoldTime)) {
                (Some(22), Some(2_000)) => old += 1,
                (Some(23), Some(12_345)) => new += 1,
                other => panic!("{other:?} after {part}/64 of {} us", takes.as_micros()),
            }
        }
        host.bench.chip.run_until(end);
    }
    println!(
        "flash: erase and program take {changes:.0?} us; {old} cuts left the old parameters, {new} the new"
    );
    assert!(old >= 64 && new >= 1, "{old} old, {new} new");
    // And a flash that such a cut has left is written like any other.
    host.bench.chip.power_cycle();
    host.bench.run(BOOT + MS * 2_000);
    let mut host = Host::in_session(host.bench, 0);
    host.collect(Change::Begin, &[(Parameter::Kp, 24)]);
    assert_eq!(host.commit(0).value(Parameter::Kp), Some(24));
}

/// The valves vent from before flash is written until the board runs again, and the watchdog does
/// not bite.
#[test]
fn the_valves_vent_while_flash_is_written() {
    let mut host = Host::in_session(ChipBench::running(0), 0);
    host.collect(Change::Begin, &[(Parameter::Kp, 12)]);
    assert_eq!(host.change(Change::Commit), Some(ChangeAnswer::Taken));
    host.bench.run_until_seen(MS * 30, |bench| bench.chip.flash_busy_until() > Ticks::ZERO);
    assert!(host.bench.drives_vent());
    let resets = host.bench.chip.resets().len();
    while host.bench.chip.resets().len() == resets {
        assert!(host.bench.drives_vent());
        assert!(host.bench.chip.now() < Ticks::from_millis(3_000));
        host.bench.run(Ticks::from_micros(500));
    }
    host.bench.run(BOOT);
    assert!(host.bench.drives_vent(), "power-up vent");
}
