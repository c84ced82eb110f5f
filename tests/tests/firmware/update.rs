//! Updates over the bus on the emulated chip: tried once, kept when confirmed, and gone in all
//! other cases.
//!
//! `cargo test -p system-tests --test firmware update:: -- --nocapture` prints the figures that
//! docs/firmware.md states.

mod power;
mod programs;

use std::sync::OnceLock;

use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{
    LastTrial, PageEntry, Running, Update, UpdateEntry, UpdateOutcome, UpdateReply, UpdateState, number_in,
};
use pneudrive_protocol::program::crc;
use system_tests::chip_bench::ChipBench;
use system_tests::firmware;
use system_tests::update_bench::{UpdateBench, next_version, pieces, program_of};

const MS: Ticks = Ticks::from_millis(1);
const LATEST: Ticks = Ticks::from_micros(20);

/// A board that has all of the next version, before the commit. Made once: 21,500 requests.
fn sent() -> UpdateBench {
    static SENT: OnceLock<UpdateBench> = OnceLock::new();
    SENT.get_or_init(|| {
        let mut host = UpdateBench::in_session(ChipBench::running(0));
        let (program, started) = (next_version(), host.bench.chip.now());
        host.send(&program);
        let took = host.bench.chip.now() - started;
        println!(
            "{} bytes in {} requests: {:.1} s, answers after at most {:.2} us",
            program.len(),
            pieces(&program).len(),
            took.as_micros() / 1e6,
            host.slowest.as_micros()
        );
        assert!(host.slowest <= LATEST, "{} us", host.slowest.as_micros());
        assert_eq!(host.bench.chip.flash_busy_until(), Ticks::ZERO, "nothing is written before the commit");
        host
    })
    .clone()
}

/// The next version on trial.
fn on_trial() -> UpdateBench {
    static TRIAL: OnceLock<UpdateBench> = OnceLock::new();
    TRIAL
        .get_or_init(|| {
            let mut host = sent();
            host.commit();
            host
        })
        .clone()
}

fn state(outcome: UpdateOutcome, running: Running, last_trial: LastTrial) -> UpdateState {
    UpdateState { outcome, running, last_trial, longest_kib: 127 }
}

const FLASHED: UpdateState = UpdateState {
    outcome: UpdateOutcome::None,
    running: Running::Flashed,
    last_trial: LastTrial::None,
    longest_kib: 127,
};

/// Every place once, over power cycles; and no access that the emulation does not know.
#[test]
fn an_update_that_is_confirmed_stays_until_the_next() {
    let mut host = sent();
    assert_eq!(host.state(), FLASHED);
    assert_eq!(host.running_crc(), 0);
    let mut expected = crc(&next_version());
    let mut host = on_trial();
    assert_eq!(host.state(), state(UpdateOutcome::None, Running::TrialSecond, LastTrial::None));
    assert_eq!(host.running_crc(), expected);
    assert_eq!(host.place(1, next_version().len()), next_version());
    for running in [Running::Second, Running::First] {
        if running == Running::Second {
            host.confirm();
        } else {
            // From the second update on one record is written, and there are two.
            let (old, new) = ((Running::Second, crc(&next_version())), (Running::First, expected));
            let after = power::cuts_while_confirmed(&mut host, 2, 16);
            assert!(after.iter().all(|cut| *cut == old || *cut == new), "{after:x?}");
            assert_eq!((after[0], after[33]), (old, new));
        }
        for _ in 0..2 {
            assert_eq!(host.state(), state(UpdateOutcome::None, running, LastTrial::None));
            assert_eq!(host.running_crc(), expected);
            host.power_cycle();
        }
        if running == Running::Second {
            // Back to the version that was flashed, as an update into its own place.
            let old = program_of(firmware::elf());
            expected = crc(&old);
            host.bench.run(MS * 2_000);
            host = UpdateBench::in_session(host.bench);
            host.send(&old);
            host.commit();
            assert_eq!(host.state().running, Running::TrialFirst);
        }
    }
    let unmodelled: Vec<_> = host.bench.chip.unmodelled_accesses().collect();
    assert!(unmodelled.is_empty(), "{unmodelled:?}");
}

/// The board vents from before flash is written until its power-up vent ends, and nothing of the
/// valves is ever low.
#[test]
fn the_valves_vent_all_the_time_and_the_board_is_away_for_a_second() {
    let mut host = sent();
    host.command();
    assert_eq!(host.update(Update::Commit), UpdateReply::Taken);
    let committed = host.bench.chip.now();
    host.bench.run_until_seen(MS * 100, |bench| bench.chip.flash_busy_until() > Ticks::ZERO);
    assert!(host.bench.drives_vent());
    while host.bench.chip.resets().len() == 1 {
        assert!(host.bench.drives_vent());
        host.bench.run(MS);
        assert!(host.bench.chip.now() - committed < MS * 2_000);
    }
    let written = host.bench.chip.now();
    host.forget();
    // A board that is asked before its first control step does not answer, and not too late either.
    while host.try_ask(PageEntry::State).is_none() {
        host.bench.run(MS);
    }
    println!(
        "from the commit to the restart {:.0} ms, to the first answer {:.0} ms more",
        (written - committed).as_micros() / 1e3,
        (host.bench.chip.now() - written).as_micros() / 1e3
    );
    // For as long as it is on trial, whatever it is told.
    let offer = host.ask(PageEntry::Session(3));
    host.host.begin(offer);
    for _ in 0..20 {
        let bytes = host.host.command([500; 4]);
        assert!(host.bench.exchange_bytes(&bytes).is_some());
        host.bench.run(MS * 200);
        assert!(host.bench.drives_vent());
    }
}

/// After each kind of request, and after many of the pieces: the host falls silent, and the board
/// goes on with the old program.
#[test]
fn a_host_that_stops_anywhere_changes_nothing() {
    let program = next_version();
    let sending = pieces(&program);
    let mut host = UpdateBench::new(ChipBench::running(0));
    let check = |host: &UpdateBench, at: &str| {
        let mut alone = host.clone();
        alone.bench.run(MS * 600);
        alone.forget();
        assert_eq!(alone.state(), FLASHED, "{at}");
        assert_eq!(number_in(alone.ask(PageEntry::Program(UpdateEntry::Received))), Some(0), "{at}");
        assert_eq!((alone.bench.chip.resets().len(), alone.bench.chip.flash_busy_until()), (1, Ticks::ZERO));
    };
    let offer = host.ask(PageEntry::Session(3));
    check(&host, "session");
    host.host.begin(offer);
    host.command();
    check(&host, "command");
    assert_eq!(host.update(Update::Begin), UpdateReply::Taken);
    check(&host, "begin");
    // Vectors, header, pages' ends of 256 bytes and sectors' of 4096, the last pieces and those of
    // the CRC, and some between.
    let near = |n: usize, every: usize| (n * 3) % every < 6;
    let last = sending.len();
    let mut stops = 0;
    for (n, piece) in sending.into_iter().enumerate() {
        if n % 100 == 0 {
            host.command();
        }
        assert_eq!(host.update(Update::Bytes(piece)), UpdateReply::Taken);
        if n < 4 || (n < 3_000 && near(n, 256) && n % 7 == 0) || near(n, 4096) || n + 4 > last {
            check(&host, "piece");
            stops += 1;
        }
    }
    assert!(stops > 40, "{stops}");
    println!("the host stopped after {stops} of {last} pieces, and after each other kind of request");
    // After the commit, and after a session with the new program: it is back by itself.
    host.commit();
    assert_eq!(host.state().running, Running::TrialSecond);
    let mut in_session = host.clone();
    let offer = in_session.ask(PageEntry::Session(4));
    in_session.host.begin(offer);
    in_session.command();
    for mut host in [host, in_session] {
        host.bench.run(MS * 9_000);
        host.bench.run(MS * 1_200);
        host.forget();
        assert_eq!(host.state(), state(UpdateOutcome::None, Running::Flashed, LastTrial::NotConfirmed));
        assert_eq!(host.running_crc(), 0);
    }
}
