//! Updates over the bus on the emulated chip: tried once, kept when confirmed, and gone in all other cases.
//!
//! `cargo test -p system-tests --test firmware update:: -- --nocapture` prints the figures that docs/firmware.md states.

use std::sync::OnceLock;

use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{
    LastTrial, PageEntry, Running, Update, UpdateEntry, UpdateOutcome, UpdateReply, UpdateState, number_in,
};
use pneudrive_protocol::program::crc;
use system_tests::chip_bench::{BOOT, ChipBench};
use system_tests::firmware;
use system_tests::update_bench::{TRIAL_BOOT, UpdateBench, next_version, pieces, program_of};

const MS: Ticks = Ticks::from_millis(1);
const LATEST: Ticks = Ticks::from_micros(20);
/// Branches to itself.
const HANG: u16 = 0xE7FE;
/// Returns at once.
const RETURN: u16 = 0x4770;

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
            let after = cuts_while_confirmed(&mut host, 2, 16);
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

/// The board vents from before flash is written until its power-up vent ends, and nothing of the valves is ever low.
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

/// Each erase and each page, at its beginning, in its middle and at its end.
#[test]
fn a_power_cut_at_any_page_leaves_the_old_program() {
    let mut host = sent();
    host.command();
    assert_eq!(host.update(Update::Commit), UpdateReply::Taken);
    let (mut changes, mut cuts) = (0, 0);
    loop {
        let before = host.bench.chip.flash_busy_until();
        host.bench.run_until_seen(MS * 200, |bench| {
            bench.chip.flash_busy_until() > before || bench.chip.resets().len() > 1
        });
        let (begin, end) = (host.bench.chip.now(), host.bench.chip.flash_busy_until());
        if host.bench.chip.resets().len() > 1 {
            break;
        }
        changes += 1;
        for part in 0..=2 {
            let mut cut = host.clone();
            cut.bench.chip.run_until(begin + Ticks::new(end.saturating_sub(begin).get() * part / 2));
            cut.power_cycle();
            assert_eq!(cut.state(), FLASHED, "change {changes}, part {part}");
            cuts += 1;
        }
        host.bench.chip.run_until(end);
    }
    let length = next_version().len();
    assert_eq!(changes, length.div_ceil(4096) + length.div_ceil(256));
    // What was written is there, but nobody has been told.
    host.power_cycle();
    assert_eq!(host.state(), FLASHED);
    println!("{cuts} power cuts at {changes} erases and pages left the old program");
}

/// While the program on trial starts and runs, until it is confirmed.
#[test]
fn a_power_cut_during_the_trial_leaves_the_old_program() {
    let mut host = sent();
    host.command();
    assert_eq!(host.update(Update::Commit), UpdateReply::Taken);
    while host.bench.chip.resets().len() == 1 {
        host.bench.run(MS);
    }
    for _ in 0..40 {
        host.bench.run(MS * 5);
        let mut cut = host.clone();
        cut.power_cycle();
        assert_eq!(cut.state(), FLASHED);
    }
    host.forget();
    assert_eq!(host.state().running, Running::TrialSecond);
}

/// Confirms a trial and cuts the supply at so many moments of each of the erases and programs that follow; what the boards run then.
fn cuts_while_confirmed(host: &mut UpdateBench, changes: usize, parts: u64) -> Vec<(Running, u32)> {
    let offer = host.ask(PageEntry::Session(4));
    host.host.begin(offer);
    host.command();
    assert_eq!(host.update(Update::Confirm), UpdateReply::Taken);
    let confirmed = host.bench.chip.now();
    let resets = host.bench.chip.resets().len();
    let mut after = Vec::new();
    for _ in 0..changes {
        let before = host.bench.chip.flash_busy_until();
        host.bench.run_until_seen(MS * 300, |bench| bench.chip.flash_busy_until() > before);
        let (begin, end) = (host.bench.chip.now(), host.bench.chip.flash_busy_until());
        for part in 0..=parts {
            let mut cut = host.clone();
            cut.bench.chip.run_until(begin + Ticks::new(end.saturating_sub(begin).get() * part / parts));
            cut.power_cycle();
            after.push((cut.state().running, cut.running_crc()));
        }
        host.bench.chip.run_until(end);
    }
    host.bench.run_until_seen(MS * 300, |bench| bench.chip.resets().len() > resets);
    let took = host.bench.chip.now() - confirmed;
    println!("from the confirmation to the restart {:.0} ms", took.as_micros() / 1e3);
    host.bench.run(BOOT);
    host.forget();
    after
}

/// The first update writes a record of the program that was flashed, too. At 65 moments of each erase and each program.
#[test]
fn a_power_cut_while_it_is_confirmed_leaves_the_old_or_the_new() {
    let mut host = on_trial();
    let (flashed, next) = (crc(&program_of(firmware::elf())), crc(&next_version()));
    let after = cuts_while_confirmed(&mut host, 4, 64);
    let new = after.iter().filter(|cut| **cut == (Running::Second, next)).count();
    let old = |cut: &&(Running, u32)| [(Running::Flashed, 0), (Running::First, flashed)].contains(cut);
    let old = after.iter().filter(old).count();
    println!(
        "{} power cuts while the records were written: {old} left the old program, {new} the new",
        after.len()
    );
    assert_eq!(old + new, after.len(), "{after:x?}");
    assert!(old >= 195 && new >= 1, "{old} old, {new} new");
}

/// After each kind of request, and after many of the pieces: the host falls silent, and the board goes on with the old program.
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
    // Vectors, header, pages' ends of 256 bytes and sectors' of 4096, the last pieces and those of the CRC, and some between.
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

/// A program broken at one instruction, in the place of the one that was sent; gives the board when its trial is over.
fn tried(broken: &[u8], trial: Ticks) -> UpdateBench {
    let program = program_of(broken);
    let mut host = sent();
    host.replace(&program, crc(&program));
    host.command();
    assert_eq!(host.update(Update::Commit), UpdateReply::Taken);
    host.bench.run(TRIAL_BOOT + trial);
    host.forget();
    host
}

#[test]
fn a_program_that_hangs_or_never_answers_is_gone_again() {
    for (function, instruction, trial) in [
        // Before it has started anything: the boot stage's watchdog.
        ("program_start", HANG, MS * 3_000),
        ("safe_state5enter", HANG, MS * 3_000),
        // Its own watchdog.
        ("ControlLoop4step", HANG, MS * 400),
        ("DMA_IRQ_1", RETURN, MS * 400),
        // All is well but that no answer leaves it.
        ("on_answer_alarm", RETURN, MS * 10_500),
    ] {
        let mut host = tried(&firmware::with_broken(function, instruction), trial);
        assert_eq!(
            host.state(),
            state(UpdateOutcome::None, Running::Flashed, LastTrial::NotConfirmed),
            "{function}"
        );
        let resets = host.bench.chip.resets().len();
        assert_eq!(resets, 3, "{function}: once into the trial, once out of it");
        host.bench.run(MS * 3_000);
        assert_eq!(host.bench.chip.resets().len(), resets, "it is tried once");
        host = UpdateBench::in_session(host.bench);
        assert_eq!(host.update(Update::Begin), UpdateReply::Taken, "and the board takes the next update");
    }
}

/// What is refused before anything is written.
#[test]
fn a_damaged_or_foreign_program_is_not_written() {
    let good = next_version();
    let changed = |at: usize, byte: u8| {
        let mut program = good.clone();
        program[at] ^= byte;
        program
    };
    let cases = [
        (changed(20_000, 4), crc(&good), UpdateOutcome::Damaged),
        (good.clone(), crc(&good) ^ 1, UpdateOutcome::Damaged),
        // As if its CRC were right: another mark, a length beyond all, another chip, an entry in flash.
        (changed(192, 1), 0, UpdateOutcome::NotAProgram),
        (changed(199, 1), 0, UpdateOutcome::NotAProgram),
        (changed(7, 0x30), 0, UpdateOutcome::NotAProgram),
        (changed(200, 3), 0, UpdateOutcome::OtherChip),
    ];
    for (program, sum, expected) in cases {
        let mut host = sent();
        host.replace(&program, if sum == 0 { crc(&program) } else { sum });
        host.command();
        assert_eq!(host.update(Update::Commit), UpdateReply::Taken);
        host.bench.run(MS * 200);
        assert_eq!(host.state(), UpdateState { outcome: expected, ..FLASHED });
        assert_eq!((host.bench.chip.resets().len(), host.bench.chip.flash_busy_until()), (1, Ticks::ZERO));
    }
}

/// Flash that does not keep what was written, or loses it later: the boot stage looks at every start.
#[test]
fn a_program_that_flash_has_lost_is_not_started() {
    let length = next_version().len();
    let host = on_trial();
    let mut confirmed = host.clone();
    confirmed.confirm();
    assert_eq!(confirmed.state().running, Running::Second);
    for byte in [0, 5, 196, 203, 30_001, length - 1] {
        // The flash as it is, with one bit less.
        let mut flash: Vec<u8> = (0..0x50_000)
            .map(|n| confirmed.bench.chip.read_memory(0x1000_0000 + n).unwrap_or(0xff))
            .collect();
        let at = 0x2_4000 + byte;
        flash[at] ^= if flash[at] == 0 { 1 } else { flash[at] & flash[at].wrapping_neg() };
        let chip = pneudrive_chip::Chip::from_flash(&flash).unwrap_or_else(|error| panic!("{error}"));
        let mut bench = ChipBench::on_board(chip, 0);
        bench.run(BOOT * 2);
        let mut host = UpdateBench::new(bench);
        assert_eq!(host.state(), state(UpdateOutcome::None, Running::First, LastTrial::None), "byte {byte}");
        // Both lost: nothing is started, and all valves vent.
        flash[0x4000 + 30_000] ^= 1;
        let chip = pneudrive_chip::Chip::from_flash(&flash).unwrap_or_else(|error| panic!("{error}"));
        let mut bench = ChipBench::on_board(chip, 0);
        bench.run(BOOT * 3);
        assert!(bench.drives_vent());
        assert_eq!(UpdateBench::new(bench).try_ask(PageEntry::State), None);
    }
}
