//! The host brings emulated chips a new program over the virtual bus: its own code, in virtual
//! time.
//!
//! `cargo test -p system-tests --test host update:: -- --nocapture` prints how long an update
//! takes.

use pneudrive_host::bus::{Bus, BusOptions, PageError, UpdateError, UpdateProgress, Updated};
use pneudrive_host::program_file::ProgramFile;
use pneudrive_protocol::Counts;
use pneudrive_protocol::pages::{ChipKind, LastTrial, PageEntry, Running, Update, UpdateOutcome};
use pneudrive_sim::rig::{Firmware, RigOptions};
use system_tests::firmware;
use system_tests::update_bench::{next_version, program_of};
use system_tests::virtual_bus::{Lost, VirtualBus, bus};

/// Returns at once.
const RETURN: u16 = 0x4770;

fn chips(boards: usize, faults: &[&str]) -> Bus<VirtualBus> {
    let options = RigOptions {
        boards,
        firmware: Some(Firmware::new(firmware::elf())),
        faults: faults.iter().map(|text| text.parse().unwrap()).collect(),
        strict: faults.is_empty(),
        ..RigOptions::default()
    };
    let mut bus = bus(&options, BusOptions::default());
    pass(&mut bus, 2.5);
    bus
}

fn pass(bus: &mut Bus<VirtualBus>, seconds: f64) {
    let now_s = bus.line().rig_now_ns() as f64 / 1e9;
    bus.line_mut().sleep_until_s(now_s + seconds);
}

fn next() -> ProgramFile {
    ProgramFile::parse(&next_version()).unwrap()
}

/// One of two boards; the other one is asked meanwhile by nobody and goes on as it was.
#[test]
fn an_update_reaches_its_board_and_stays() {
    let mut bus = chips(2, &[]);
    let started_ns = bus.line().rig_now_ns();
    let mut told = Vec::new();
    let done = bus.update_board(1, &next(), |progress| told.push(progress));
    println!("an update takes {:.1} s", (bus.line().rig_now_ns() - started_ns) as f64 / 1e9);
    assert_eq!(done, Ok(Updated::Done));
    assert_eq!(told[told.len() - 2..], [UpdateProgress::Writing, UpdateProgress::Confirming]);
    let (bytes, of) = (next().bytes().len(), next().bytes().len());
    assert!(told.contains(&UpdateProgress::Sent { bytes, of }), "{told:?}");
    assert_eq!(bus.running_crc(1), Ok(next().crc()));
    assert_eq!(bus.update_state(1).unwrap().running, Running::Second);
    assert_eq!(bus.update_board(1, &next(), |_| {}), Ok(Updated::Unchanged));
    assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed);
    assert_eq!(bus.line().counters().unasked, 0);
}

/// A wire that damages and loses: pieces are sent again, and each arrives once.
#[test]
fn an_update_arrives_whole_over_a_bad_line() {
    for fault in ["drop=0.0005,on=requests", "drop=0.0005,on=answers"] {
        let mut bus = chips(1, &[fault]);
        assert_eq!(bus.update_board(0, &next(), |_| {}), Ok(Updated::Done), "{fault}");
        let struck = bus.line().counters().fault("drop");
        assert!(struck > 50, "{fault}: {struck}");
        assert_eq!(bus.running_crc(0), Ok(next().crc()));
    }
}

/// Commit and confirmation are each said once more if they were lost. Lost is each of the exchanges
/// that follow the last piece, and that follow the new program's first answer; one, and as many as
/// last a third of a second.
#[test]
fn whichever_request_is_lost_at_the_end_the_update_is_done() {
    losses_at_the_end(Lost::Request);
}

/// The same, and they are not said again if only their answers were lost: the board works on them,
/// and would refuse a second one.
#[test]
fn whichever_answer_is_lost_at_the_end_the_update_is_done() {
    losses_at_the_end(Lost::Answer);
}

fn losses_at_the_end(lost: Lost) {
    for (others, count) in [(0, 1), (1, 1), (2, 1), (3, 1), (4, 1), (0, 30), (2, 30)] {
        let mut bus = chips(1, &[]);
        let plan = bus.line().losses_to_come();
        let mut losses = 0;
        let done = bus.update_board(0, &next(), |progress| {
            if matches!(progress, UpdateProgress::Writing | UpdateProgress::Confirming) {
                losses += usize::from(plan.is_done());
                plan.lose_after(others, count, lost);
            }
        });
        let which = format!("{lost:?}, {count} after {others} others");
        assert_eq!(done, Ok(Updated::Done), "{which}");
        assert_eq!((losses, plan.is_done()), (2, true), "{which}");
        assert_eq!(bus.update_state(0).unwrap().running, Running::Second, "{which}");
        assert_eq!(bus.running_crc(0), Ok(next().crc()), "{which}");
    }
}

/// An update during which so many exchanges in a row are lost after so many others that follow
/// `at`.
fn updated_with_losses(
    bus: &mut Bus<VirtualBus>,
    at: UpdateProgress,
    others: u32,
    count: u32,
    lost: Lost,
) -> Result<Updated, UpdateError> {
    let plan = bus.line().losses_to_come();
    bus.update_board(0, &next(), |progress| {
        if progress == at {
            plan.lose_after(others, count, lost);
        }
    })
}

/// The commit is lost, and all that follows it until the board has ended the session.
#[test]
fn a_board_that_hears_nothing_for_long_before_the_commit_has_forgotten_the_program() {
    let mut bus = chips(1, &[]);
    let result = updated_with_losses(&mut bus, UpdateProgress::Writing, 2, 100, Lost::Request);
    assert!(matches!(result, Err(UpdateError::Forgotten { .. })), "{result:?}");
    assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed);
    assert_eq!(bus.update_board(0, &next(), |_| {}), Ok(Updated::Done));
}

/// Nothing reaches the new program, or nothing of it the host, while it is on trial.
#[test]
fn a_trial_that_ends_in_silence_is_a_rollback() {
    for lost in [Lost::Request, Lost::Answer] {
        let mut bus = chips(1, &[]);
        // 850 questions take 10.4 s.
        let result = updated_with_losses(&mut bus, UpdateProgress::Confirming, 0, 850, lost);
        let not_confirmed =
            matches!(result, Err(UpdateError::RolledBack { last_trial: LastTrial::NotConfirmed, .. }));
        assert!(not_confirmed, "{lost:?}: {result:?}");
        assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed, "{lost:?}");
    }
}

/// The line is cut when the new program has answered, before it was confirmed, and when it was: the
/// host says what it knows, and what it does not know is found out by the same command.
#[test]
fn a_board_that_is_never_heard_again_is_said_to_be_unknown() {
    for (others, kept) in [(0, false), (2, true)] {
        let mut bus = chips(1, &[]);
        let result =
            updated_with_losses(&mut bus, UpdateProgress::Confirming, others, u32::MAX, Lost::Answer);
        let Err(error @ UpdateError::Lost { confirmed, .. }) = &result else { panic!("{result:?}") };
        assert_eq!(*confirmed, kept, "{error}");
        let text = error.to_string();
        let says = if kept { "is not known" } else { "goes back to the one before" };
        assert!(text.contains("no answer after") && text.contains(says), "{text}");
        // The line is whole again.
        bus.line().losses_to_come().lose_after(0, 1, Lost::Answer);
        let (running, again) =
            if kept { (Running::Second, Updated::Unchanged) } else { (Running::Flashed, Updated::Done) };
        assert!(bus.update_state(0).is_err(), "the last one that is lost");
        assert_eq!(bus.update_state(0).unwrap().running, running);
        assert_eq!(bus.update_board(0, &next(), |_| {}), Ok(again));
    }
}

/// A line that is cut while the program is sent: nothing was written, and the host says so.
#[test]
fn a_line_that_is_cut_while_the_program_is_sent_leaves_the_old_one() {
    let mut bus = chips(1, &[]);
    let plan = bus.line().losses_to_come();
    let result = bus.update_board(0, &next(), |progress| {
        if matches!(progress, UpdateProgress::Sent { bytes, .. } if bytes < 1_000) {
            plan.lose_after(0, 300, Lost::Request);
        }
    });
    let Err(error @ UpdateError::Interrupted { .. }) = &result else { panic!("{result:?}") };
    assert!(error.to_string().contains("goes on with the one that it had"), "{error}");
    plan.lose_after(0, 1, Lost::Request);
    assert!(bus.update_state(0).is_err(), "the last one that is lost");
    assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed);
}

/// What the board says of an update before this one is not taken for its answer to a commit that it
/// has not heard.
#[test]
fn an_earlier_refusal_is_not_taken_for_an_answer() {
    let mut bus = chips(1, &[]);
    // A session begins with the command after the one that finds the board.
    bus.ping(0).unwrap();
    for update in [Update::Begin, Update::Commit] {
        // Like the host itself: a command goes ahead.
        let answered = (0..5).any(|_| bus.ping(0).is_ok() && bus.page(0, PageEntry::Update(update)).is_ok());
        assert!(answered, "{update:?}");
    }
    pass(&mut bus, 0.1);
    assert_eq!(bus.update_state(0).unwrap().outcome, UpdateOutcome::NotAProgram);
    let plan = bus.line().losses_to_come();
    let done = bus.update_board(0, &next(), |progress| {
        if progress == UpdateProgress::Writing {
            // After the question where it is, and the command that goes ahead.
            plan.lose_after(2, 1, Lost::Request);
        }
    });
    assert_eq!(done, Ok(Updated::Done));
    assert!(plan.is_done());
}

/// The supply fails while the program is sent, and after it: the old program, and the next update
/// succeeds.
#[test]
fn a_board_that_loses_its_supply_has_the_old_program() {
    for at in ["power_cycle@4,board=0,ms=50", "power_cycle@12,board=0,ms=50"] {
        let mut bus = chips(1, &[at]);
        let mut sent = 0;
        let result = bus.update_board(0, &next(), |progress| {
            if let UpdateProgress::Sent { bytes, .. } = progress {
                sent = bytes;
            }
        });
        if at.contains("@4") {
            assert!(result.is_err() && sent > 0 && sent < next().bytes().len(), "{result:?} {sent}");
            pass(&mut bus, 1.0);
            assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed);
            assert_eq!(bus.update_board(0, &next(), |_| {}), Ok(Updated::Done));
        }
        // After 12 s at the latest all is over, and the cut changes nothing.
        pass(&mut bus, 10.0);
        assert_eq!(bus.update_state(0).unwrap().running, Running::Second);
    }
}

#[test]
fn a_program_that_never_answers_is_said_to_be_gone() {
    let mut bus = chips(1, &[]);
    let silent = ProgramFile::parse(&firmware::with_broken("on_answer_alarm", RETURN)).unwrap();
    assert_eq!(silent.bytes().len(), program_of(firmware::elf()).len());
    let refused = bus.update_board(0, &silent, |_| {}).unwrap_err();
    assert!(
        matches!(refused, UpdateError::RolledBack { last_trial: LastTrial::NotConfirmed, .. }),
        "{refused}"
    );
    assert_eq!(bus.running_crc(0), Ok(0));
}

#[test]
fn who_cannot_be_updated_says_so() {
    let mut bus = chips(1, &[]);
    let mut other = next_version();
    other[200] = 2;
    let refused = bus.update_board(0, &ProgramFile::parse(&other).unwrap(), |_| {}).unwrap_err();
    assert!(
        matches!(refused, UpdateError::OtherChip { chip: ChipKind::Rp2040, wanted: ChipKind::Rp2350, .. }),
        "{refused}"
    );
    let native = RigOptions { boards: 1, ..RigOptions::default() };
    let refused = system_tests::virtual_bus::bus(&native, BusOptions::default())
        .update_board(0, &next(), |_| {})
        .unwrap_err();
    assert!(matches!(refused, UpdateError::Unsupported { chip: ChipKind::Native, .. }), "{refused}");
    let mut bare = system_tests::virtual_bus::bus(
        &RigOptions { firmware: Some(Firmware::new(firmware::elf())), ..native.clone() },
        BusOptions::default().sessions(false),
    );
    pass(&mut bare, 2.5);
    let refused = bare.update_board(0, &next(), |_| {}).unwrap_err();
    assert!(matches!(refused, UpdateError::NoSession { .. }), "{refused}");
    let unchecked = BusOptions::default().formats(pneudrive_host::bus::FormatPolicy::Unchecked);
    let refused = system_tests::virtual_bus::bus(&native, unchecked).update_board(0, &next(), |_| {});
    assert!(matches!(refused, Err(UpdateError::Page(PageError::NotChecked { .. }))), "{refused:?}");
}

/// Seen before 64 KB are sent for nothing.
#[test]
fn a_board_with_pressure_refuses() {
    let mut bus = chips(1, &[]);
    let filled = [Counts::saturating(500); 4];
    for _ in 0..200 {
        bus.exchange(0, filled).unwrap();
        pass(&mut bus, 0.01);
    }
    let mut sent = 0;
    let refused = bus.update_board(0, &next(), |_| sent += 1).unwrap_err();
    assert!(matches!(refused, UpdateError::NotVented { .. }), "{refused}");
    assert_eq!(sent, 0);
    assert_eq!(bus.update_state(0).unwrap().running, Running::Flashed);
}
