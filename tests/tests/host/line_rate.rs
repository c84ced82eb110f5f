//! A whole bus goes to a faster line rate and back, in virtual time: host and virtual boards.
//!
//! `cargo test -p system-tests --test host line_rate:: -- --nocapture` prints what hosts are told.

use pneudrive_control::BoardConfig;
use pneudrive_host::bus::{Bus, BusOptions, FormatPolicy, LineRateError};
use pneudrive_host::line::Line;
use pneudrive_host::notices::NoticeWriter;
use pneudrive_host::poller::{
    BoardState, Event, LineRatePolicy, Observer, Pace, PollerOptions, Polling, Row, SetPoints,
};
use pneudrive_protocol::pages::{LineRate, LineRateState, RateReturn, StateNow};
use pneudrive_protocol::{Baud, Counts};
use pneudrive_sim::rig::RigOptions;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use system_tests::cable::Cable;
use system_tests::virtual_bus::{VirtualBus, bus};

const MS: u64 = 1_000_000;

/// What people are told.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<(NoticeWriter, Vec<String>)>>);

impl Observer for Told {
    fn row(&mut self, _: &Row<'_>) {}

    fn event(&mut self, event: &Event<'_>) {
        let (narrator, lines) = &mut *self.0.lock().unwrap();
        lines.extend(narrator.notice(event).map(|notice| format!("{}: {}", notice.kind.name(), notice.text)));
    }
}

impl Told {
    fn take(&self) -> Vec<String> {
        let lines = std::mem::take(&mut self.0.lock().unwrap().1);
        lines.iter().for_each(|line| println!("{line}"));
        lines
    }
}

struct Run {
    polling: Polling<Cable<VirtualBus>>,
    points: SetPoints,
    told: Told,
}

fn rig(boards: usize) -> RigOptions {
    RigOptions { boards, ..RigOptions::default() }
}

impl Run {
    fn start(rig: &RigOptions, options: BusOptions, pace: Pace) -> Self {
        let wire = bus(rig, options).into_line();
        let bus = Bus::new(Cable::sound(wire), options).unwrap();
        let told = Told::default();
        let points = SetPoints::new(rig.boards);
        let options =
            PollerOptions::for_devices(rig.boards as u16).pace(pace).line_rate(LineRatePolicy::default());
        let polling = Polling::new(bus, options, Box::new(points.clone()), vec![Box::new(told.clone())]);
        Self { polling, points, told }
    }

    fn fast(rig: &RigOptions) -> Self {
        Self::start(rig, BusOptions::default(), Pace::AsFastAsPossible)
    }

    fn now_ns(&mut self) -> u64 {
        self.polling.bus_mut().line().now_ns()
    }

    fn poll(&mut self, ms: u64) {
        let end_ns = self.now_ns() + ms * MS;
        while self.now_ns() < end_ns {
            let due_ns = self.polling.next_cycle_ns();
            self.polling.bus_mut().line_mut().sleep_until(due_ns);
            self.polling.cycle().unwrap();
        }
    }

    fn silence(&mut self, ms: u64) {
        let until_ns = self.now_ns() + ms * MS;
        self.polling.bus_mut().line_mut().sleep_until(until_ns);
    }

    fn baud(&mut self) -> u32 {
        self.polling.bus_mut().baud().get()
    }

    fn state(&mut self, board: u8) -> LineRateState {
        self.polling.bus_mut().line_rate_state(board).unwrap()
    }
}

#[test]
fn four_boards_go_to_3_mbaud_and_poll_at_its_limit_without_a_loss() {
    let mut run = Run::fast(&RigOptions { strict: true, ..rig(4) });
    run.poll(2_000);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 3000000 baud"]);
    assert_eq!(run.baud(), 3_000_000);
    let statistics = run.polling.finish();
    // 66.7 us on the wire and 15 us of turnaround; the first cycle asks and tries.
    let limit = 1e9 / (4.0 * (66_667.0 + 15_000.0));
    assert!((statistics.cycles as f64 / 2.0 / limit - 1.0).abs() < 0.01, "{statistics:?}, limit {limit} Hz");
    assert_eq!((statistics.lost, statistics.rejected, statistics.baud), (0, 0, Some(3_000_000)));
    for board in 0..4 {
        let state = run.state(board);
        assert_eq!((state.now, state.returns), (LineRate::ThreeMbaud, 0));
    }
    assert_eq!(run.polling.bus_mut().counters(0).lost(), 0);
}

#[test]
fn at_the_end_all_are_back_for_whoever_comes_next() {
    let rig = rig(2);
    let mut run = Run::fast(&rig);
    run.poll(500);
    assert_eq!(run.baud(), 3_000_000);
    assert_eq!(run.polling.make_safe(), Ok(vec![]));
    assert_eq!(run.baud(), 1_000_000);
    let wire = run.polling.into_bus().into_line().line;
    let options = BusOptions::default().formats(FormatPolicy::Unchecked);
    let mut next = Bus::new(wire, options).unwrap();
    for board in 0..2 {
        assert!(next.ping(board).is_ok(), "board {board}, at once and in the original's format");
    }
}

/// The host is stopped for longer than boards keep a rate, and for less than they wait for
/// commands.
#[test]
fn a_host_that_was_stopped_finds_its_boards_at_1_mbaud_and_nothing_has_happened() {
    let mut run = Run::fast(&rig(4));
    run.poll(2_500);
    for board in 0..4 {
        run.points.set(board, [Counts::saturating(300); 4]).unwrap();
    }
    run.poll(500);
    run.told.take();
    run.silence(150);
    run.poll(300);
    let told = run.told.take();
    assert_eq!(run.baud(), 1_000_000);
    assert!(told[0].starts_with("line_rate_lowered: back from 3000000 to 1000000 baud: board "), "{told:?}");
    assert_eq!(told.len(), 1, "no board was missing: {told:?}");
    for board in 0..4 {
        let state = run.state(board);
        assert_eq!((state.now, state.last_return), (LineRate::Compiled, Some(RateReturn::Silence)));
        assert_eq!(run.polling.bus_mut().board_state(board).unwrap().board, StateNow::Running);
    }
    // Not before 10 s, and then the same rate: it is not the line that failed.
    run.poll(9_000);
    assert_eq!((run.told.take(), run.baud()), (vec![], 1_000_000));
    run.poll(1_500);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 3000000 baud"]);
}

#[test]
fn errors_send_all_back_and_a_slower_rate_is_tried_later() {
    let mut run = Run::fast(&rig(2));
    run.poll(500);
    assert_eq!(run.baud(), 3_000_000);
    run.told.take();
    // One answer in 25: too few in a row to be noticed otherwise.
    let line = run.polling.bus_mut().line_mut();
    (line.from, line.every) = (Baud::THREE_MBAUD, 251);
    run.poll(2_000);
    let told = run.told.take();
    assert_eq!(run.baud(), 1_000_000);
    assert!(told[0].contains("exchanges were lost within a second; asked again after 10 s"), "{told:?}");
    let lost = run.polling.statistics().lost;
    assert!((20..=26).contains(&lost), "{lost} were lost");
    run.poll(10_000);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 2000000 baud"]);
    run.poll(5_000);
    assert_eq!((run.baud(), run.told.take()), (2_000_000, vec![]));
    assert_eq!(run.polling.statistics().lost, lost);
}

/// Nothing at all comes through at 3 Mbaud: the trial ends it, boards are silent for 0.1 s, and
/// none of them holds or is missing.
#[test]
fn a_trial_that_fails_costs_a_tenth_of_a_second() {
    let mut run = Run::fast(&rig(3));
    let line = run.polling.bus_mut().line_mut();
    (line.from, line.every) = (Baud::THREE_MBAUD, 1);
    run.poll(400);
    let told = run.told.take();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].starts_with(
            "line_rate: the line rate stays at 1000000 baud: board 1 (0xFFFE) does not answer as it should at"
        ),
        "{told:?}"
    );
    run.poll(600);
    let statistics = run.polling.statistics();
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Present), "{statistics:?}");
    for board in 0..3 {
        assert_eq!(run.state(board).now, LineRate::Compiled);
    }
    // It is tried once more, since a failure may be a passing one, before a slower rate is.
    run.poll(10_000);
    let told = run.told.take();
    assert!(told.len() == 1 && told[0].ends_with("asked again after 20 s"), "{told:?}");
    run.poll(20_000);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 2000000 baud"]);
}

/// A board that starts anew is at the rate that it was compiled for.
#[test]
fn a_board_that_lost_its_supply_brings_all_back() {
    let faults = vec!["power_cycle@1,board=1,ms=50".parse().unwrap()];
    let mut run = Run::fast(&RigOptions { faults, ..rig(2) });
    run.poll(1_500);
    let told = run.told.take();
    assert_eq!(told[0], "line_rate: all boards have gone to 3000000 baud");
    assert!(told[1].starts_with("line_rate_lowered: "), "{told:?}");
    assert_eq!(run.baud(), 1_000_000);
    let statistics = run.polling.statistics();
    assert!(statistics.boards.iter().all(|board| board.state == BoardState::Present), "{statistics:?}");
    // As long as it has no supply, nothing faster is asked for.
    run.poll(12_000);
    assert_eq!(run.baud(), 3_000_000);
}

#[test]
fn a_board_of_the_original_kind_keeps_the_bus_at_1_mbaud() {
    let mut run = Run::fast(&RigOptions { original: [1].into(), ..rig(2) });
    run.poll(4_000);
    let told = run.told.take();
    let sentence = "board 1 (0xFFFE): it is of the original kind, which has one line rate only";
    assert!(told.iter().any(|line| line.contains(sentence)), "{told:?}");
    assert_eq!(run.baud(), 1_000_000);
    assert_eq!(run.state(0).returns, 0, "it was never asked");
}

/// Boards notice nothing of it.
#[test]
fn an_adapter_that_does_2_mbaud_gets_its_boards_there_at_the_second_try() {
    let mut run = Run::fast(&rig(2));
    run.polling.bus_mut().line_mut().adapter_does = Baud::TWO_MBAUD;
    run.poll(9_000);
    let sentence = "line_rate: the line rate stays at 1000000 baud: the adapter does not do 3000000 baud; asked again after 10 s";
    assert_eq!(run.told.take(), [sentence]);
    run.poll(3_000);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 2000000 baud"]);
    assert_eq!((run.baud(), run.polling.statistics().lost, run.state(0).returns), (2_000_000, 0, 0));
}

#[test]
fn boards_say_how_fast_they_may_be_asked_to_be() {
    for (max_baud, rate) in [(LineRate::Compiled, 1_000_000), (LineRate::TwoMbaud, 2_000_000)] {
        let control = BoardConfig { max_baud, ..BoardConfig::default() };
        let mut run = Run::fast(&RigOptions { control, ..rig(2) });
        run.poll(500);
        assert_eq!(run.baud(), rate);
        let told = run.told.take();
        let refused =
            told[0].contains("board 0 (0xFFFF): its parameter max_baud does not allow a faster rate");
        assert_eq!(refused, max_baud == LineRate::Compiled, "{told:?}");
    }
}

#[test]
fn without_sessions_no_rate_is_changed() {
    let mut bus = bus(&rig(1), BusOptions::default().sessions(false));
    bus.ping(0).unwrap();
    assert!(matches!(bus.fastest_line_rate(&[0]), Err(LineRateError::NoSession { .. })));
    let raised = bus.raise_line_rate(&[0], LineRate::ThreeMbaud);
    assert!(matches!(raised, Err(LineRateError::NoSession { .. })), "{raised:?}");
    assert!(bus.ping(0).is_ok());
}

#[test]
fn who_polls_seldom_stays_at_1_mbaud() {
    let pace = Pace::every(Duration::from_millis(60));
    let mut run = Run::start(&rig(1), BusOptions::default(), pace);
    run.poll(1_000);
    let told = run.told.take();
    let sentence = "line_rate: the line rate stays at 1000000 baud: a cycle every 60 ms would lose a faster one, which boards keep for 100 ms";
    assert_eq!(told, [sentence]);
    let pace = Pace::every(Duration::from_millis(50));
    let mut run = Run::start(&rig(1), BusOptions::default(), pace);
    run.poll(1_000);
    assert_eq!(run.told.take(), ["line_rate: all boards have gone to 3000000 baud"]);
    run.poll(3_000);
    assert_eq!((run.baud(), run.polling.statistics().lost), (3_000_000, 0));
}
