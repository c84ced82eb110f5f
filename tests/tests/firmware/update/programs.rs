//! Programs that hang, are damaged, foreign, or lost by the flash.

use super::{FLASHED, MS, on_trial, sent, state};
use pneudrive_chip::Ticks;
use pneudrive_protocol::pages::{
    LastTrial, PageEntry, Running, Update, UpdateOutcome, UpdateReply, UpdateState,
};
use pneudrive_protocol::program::crc;
use system_tests::chip_bench::{BOOT, ChipBench};
use system_tests::firmware;
use system_tests::update_bench::{TRIAL_BOOT, UpdateBench, next_version, program_of};

/// Branches to itself.
const HANG: u16 = 0xE7FE;
/// Returns at once.
const RETURN: u16 = 0x4770;

/// A program broken at one instruction, in the place of the one that was sent; gives the board when
/// its trial is over.
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
        // As if its CRC were right: another mark, a length beyond all, another chip, an entry in
        // flash.
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

/// Flash that does not keep what was written, or loses it later: the boot stage looks at every
/// start.
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
