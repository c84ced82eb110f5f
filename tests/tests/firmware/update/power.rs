//! The supply is cut: in the middle of an erase, of a trial, of a confirmation.

use super::{FLASHED, MS, on_trial, sent};
use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{PageEntry, Running, Update, UpdateReply};
use pneudrive_protocol::program::crc;
use system_tests::chip_bench::BOOT;
use system_tests::firmware;
use system_tests::update_bench::{UpdateBench, next_version, program_of};

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

/// Confirms a trial and cuts the supply at so many moments of each of the erases and programs that
/// follow; what the boards run then.
pub(super) fn cuts_while_confirmed(
    host: &mut UpdateBench,
    changes: usize,
    parts: u64,
) -> Vec<(Running, u32)> {
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

/// The first update writes a record of the program that was flashed, too. At 65 moments of each
/// erase and each program.
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
