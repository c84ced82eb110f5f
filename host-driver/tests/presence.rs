//! A board that falls silent: how soon it is back when it answers again, and what it costs the
//! others until then. In virtual time.

use crate::support::answer;
use crate::support::virtual_line::{AT_ONCE, VirtualLine};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, FormatPolicy};
use pneudrive_host::line::Line;
use pneudrive_host::poller::{BoardState, Pace, PollerOptions, Polling, SetPoints};
use pneudrive_protocol::Echo;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const MS: u64 = 1_000_000;
const TIMEOUT_NS: u64 = 2_200_000;
/// When board 1 falls silent, ns.
const FROM_NS: u64 = 100 * MS;

/// Two boards at 1 kHz, of which board 1 is silent now and then.
struct Rig {
    polling: Polling<VirtualLine>,
    silent: Arc<AtomicBool>,
    /// When board 1's state changed, and to what.
    states: Vec<(u64, BoardState)>,
}

impl Rig {
    fn new(silent: bool) -> Self {
        let silent = Arc::new(AtomicBool::new(silent));
        let theirs = Arc::clone(&silent);
        let line = VirtualLine::new(move |_, request| {
            let board = 0xFF - request[1];
            let answers = board == 0 || !theirs.load(Ordering::Relaxed);
            if answers { vec![(AT_ONCE, answer(board, 500))] } else { Vec::new() }
        });
        // No wait for late answers: with checked packets there is none, and it would hide the
        // pauses.
        let options = BusOptions::default()
            .echo(EchoMode::Known(Echo::Absent))
            .formats(FormatPolicy::Unchecked)
            .late_answer_limit(Duration::ZERO);
        let pace = Pace::every(Duration::from_millis(1));
        let polled = PollerOptions::for_devices(2).pace(pace);
        let bus = Bus::new(line, options).unwrap();
        let polling = Polling::new(bus, polled, Box::new(SetPoints::new(2)), Vec::new());
        Self { polling, silent, states: Vec::new() }
    }

    fn run_until(&mut self, end_ns: u64) {
        while self.polling.bus_mut().line().now_ns() < end_ns {
            let at_ns = self.polling.next_cycle_ns();
            self.polling.bus_mut().line_mut().sleep_until(at_ns);
            self.polling.cycle().unwrap();
            let state = self.polling.statistics().boards[1].state;
            if self.states.last().is_none_or(|&(_, before)| before != state) {
                self.states.push((self.polling.bus_mut().line().now_ns(), state));
            }
        }
    }

    fn set_silent(&self, silent: bool) {
        self.silent.store(silent, Ordering::Relaxed);
    }

    /// Requests to board 1 that were sent in this time.
    fn asked(&mut self, when_ns: std::ops::Range<u64>) -> u64 {
        let requests = &self.polling.bus_mut().line().requests;
        requests.iter().filter(|(at, request)| when_ns.contains(at) && request[1] == 0xFE).count() as u64
    }
}

/// Whatever made it silent, and for however long: it is back after about as long again, and no
/// later than a probe.
#[test]
fn a_board_that_answers_again_is_back_after_about_as_long_as_it_was_away() {
    for silent_ms in [3, 5, 7, 8, 12, 20, 35, 60, 100, 160, 400] {
        let mut rig = Rig::new(false);
        rig.run_until(FROM_NS);
        rig.set_silent(true);
        rig.run_until(FROM_NS + silent_ms * MS);
        rig.set_silent(false);
        let answers_ns = rig.polling.bus_mut().line().now_ns();
        rig.run_until(answers_ns + 300 * MS);
        let &(back_ns, state) = rig.states.last().unwrap();
        assert_eq!(state, BoardState::Present, "{silent_ms} ms");
        let late_ns = back_ns.saturating_sub(answers_ns);
        let bound_ns = (answers_ns - FROM_NS).min(100 * MS) + 2 * MS;
        assert!(late_ns <= bound_ns, "back {late_ns} ns after {silent_ms} ms of silence");
        let given_up = rig.states.iter().any(|&(_, state)| state == BoardState::Missing);
        assert_eq!(given_up, silent_ms >= 160, "{silent_ms} ms: {:?}", rig.states);
    }
}

/// Three exchanges lost in a row are nothing on a bus that damages one character in a hundred.
#[test]
fn three_losses_in_a_row_cost_milliseconds() {
    let mut rig = Rig::new(false);
    rig.run_until(FROM_NS);
    rig.set_silent(true);
    let lost = |rig: &Rig| rig.polling.statistics().lost;
    while lost(&rig) < 3 {
        let now_ns = rig.polling.bus_mut().line().now_ns();
        rig.run_until(now_ns + 1);
    }
    rig.set_silent(false);
    let lost_ns = rig.polling.bus_mut().line().now_ns();
    rig.run_until(lost_ns + 10 * MS);
    let &(back_ns, state) = rig.states.last().unwrap();
    assert_eq!((state, lost(&rig)), (BoardState::Present, 3));
    assert!(back_ns - lost_ns <= 2 * MS + 400_000, "{} ns", back_ns - lost_ns);
}

/// Three and seven timeouts while it is given up, then one in each 0.1 s: 22 ms, and 2.2 % of the
/// time.
#[test]
fn a_dead_board_costs_the_others_a_bounded_time() {
    let mut rig = Rig::new(false);
    rig.run_until(FROM_NS);
    rig.set_silent(true);
    let died_ns = rig.polling.bus_mut().line().now_ns();
    rig.run_until(died_ns + 3_000 * MS);
    let given_up_ns = rig.states.iter().find(|(_, state)| *state == BoardState::Missing).unwrap().0;
    assert!((150 * MS..160 * MS).contains(&(given_up_ns - died_ns)), "{} ns", given_up_ns - died_ns);
    assert_eq!(rig.asked(died_ns..given_up_ns), 10);
    for second in 0..2 {
        let from_ns = given_up_ns + second * 1_000 * MS;
        assert!((9..=10).contains(&rig.asked(from_ns..from_ns + 1_000 * MS)));
    }
    // All of it as the other board sees it: cycles of 1 ms that a timeout has taken the place of.
    let statistics = rig.polling.finish();
    let timeouts = statistics.boards[1].lost;
    assert_eq!(statistics.boards[0].lost, 0);
    assert!(statistics.missed_ticks * MS <= timeouts * (TIMEOUT_NS + MS), "{statistics:?}");
    assert!(statistics.boards[0].answered >= 3_100 - 3 * timeouts, "{statistics:?}");
}

/// One that has never answered is not expected to come back in a moment.
#[test]
fn a_board_that_is_not_there_costs_three_timeouts_and_probes() {
    let mut rig = Rig::new(true);
    rig.run_until(1_000 * MS);
    assert!((12..=13).contains(&rig.asked(0..1_000 * MS)), "{:?}", rig.states);
}
