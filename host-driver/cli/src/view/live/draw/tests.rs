use super::super::model::Model;
use super::*;
use crate::setup::Setup;
use crate::view::Session;
use pneudrive_host::line::Clock;
use pneudrive_host::poller::{
    BoardSensors, ChannelLimit, ElectronicsReading, Limits, Outcome, Override, Reading, Snapshot,
    SupplyPressure,
};
use pneudrive_host::rig::{Rig, Unit};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::{Counts, SensorScale};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use std::time::Duration;

fn model(boards: u8, now_ns: u64) -> Model {
    let rig = Rig::parse("rig.toml", "[boards.0]\nname = \"arm\"\n[boards.0.channels.1]\nname = \"left\"\n");
    let session = Session {
        port: "sim".into(),
        recording: Some("run.csv".into()),
        clock: Clock,
        overriding: Override::manual(&vec![[Counts::ATMOSPHERE; CHANNELS]; usize::from(boards)]),
        setup: Setup { rig: rig.ok(), ..Setup::default() },
        limits: Limits::default(),
        recorder: None,
        keep_running: false,
        watch: None,
    };
    let mut model = Model::new(session);
    let command = [SensorScale::ORIGINAL.counts(344.7).unwrap(); CHANNELS];
    let reading = Reading {
        counts: [400; CHANNELS].map(Counts::saturating),
        kpa: [100.0, 200.0, 300.0, 344.0],
        asked_ns: 0,
    };
    let state =
        if Duration::from_nanos(now_ns) > Model::OLD { BoardState::Missing } else { BoardState::Present };
    let outcome = Outcome::Fresh;
    let row = |board| BoardRow {
        board,
        command,
        wanted: command,
        outcome,
        reading: Some(reading),
        drives: None,
        sensors: BoardSensors::default(),
        state,
    };
    for cycle in [0, 500] {
        let since_start_ns = cycle * 1_000_000;
        let boards = (0..boards).map(row).collect();
        model.sample(Snapshot { cycle: Some(cycle), at_ns: 0, since_start_ns, boards }, now_ns);
    }
    model.happened("board 0 answers".into());
    model
}

fn screen(model: &Model, width: u16, height: u16) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| draw(frame, model)).unwrap();
    terminal.backend().to_string()
}

#[track_caller]
fn has(screen: &str, parts: &[&str]) {
    for part in parts {
        assert!(screen.contains(part), "{part:?} is not in\n{screen}");
    }
}

#[test]
fn every_chamber_is_there_with_pressure_command_and_deviation() {
    let screen = screen(&model(1, 1_000), 100, 14);
    has(
        &screen,
        &["PneuDrive", "REC run.csv", "1000.0 Hz", "board 0 (arm): present", "0.5 s: board 0 answers"],
    );
    has(
        &screen,
        &[
            ">0 ",
            "100.0  344.7 kPa  -244.7",
            &format!("1 {:<4} {:>6}", "left", "200.0"),
            "300.0  344.7",
            "344.0  344.7 kPa    -0.7",
        ],
    );
}

/// Where there is room, and right above the numbers.
#[test]
fn columns_are_named() {
    let roomy = screen(&model(1, 1_000), 100, 14);
    let line = |part: &str| roomy.lines().position(|line| line.contains(part)).unwrap();
    assert_eq!(line("now  set to"), line("board 0 (arm)") - 1, "{roomy}");
    let ends = |part: &str| roomy.lines().find_map(|line| Some(line.find(part)? + part.len())).unwrap();
    assert_eq!(ends(" now"), ends(" 100.0"), "{roomy}");
    assert_eq!(ends("off by"), ends("-244.7"), "{roomy}");
    assert!(!screen(&model(4, 1_000), 80, 24).contains("set to"), "boards and events come first");
    assert!(!screen(&model(1, 1_000), 39, 24).contains("set to"), "there are no such columns");
}

/// A rig of four boards is whole on the smallest usual terminal.
#[test]
fn four_boards_fit_80x24_with_keys_and_an_event() {
    let screen = screen(&model(4, 1_000), 80, 24);
    for board in 0..4 {
        has(&screen, &[&format!("board {board}")]);
    }
    assert_eq!(screen.matches(" kPa ").count(), 16, "{screen}");
    has(&screen, &["0.5 s: board 0 answers", "? keys", "q end", "v or Space vent all"]);
}

#[test]
fn old_pressures_are_not_shown() {
    let screen = screen(&model(1, 2_000_000_000), 100, 14);
    has(&screen, &["MISSING, last seen 2.0 s ago", &format!("0 {:<4} {:>6}", "", "---")]);
    assert!(!screen.contains("100.0"), "{screen}");
}

#[test]
fn bars_end_at_the_limit_and_numbers_have_the_unit() {
    let mut model = model(1, 1_000);
    let limit = ChannelLimit { max_kpa: 400.0, ..ChannelLimit::NONE };
    model.session.limits = Limits::everywhere(limit).unwrap();
    model.session.setup.unit = Unit::Bar;
    has(&screen(&model, 100, 14), &["scale 0 to 4.000 bar", "1.000  3.447 bar  -2.447"]);
    model.session.limits = Limits::default();
    model.session.setup.unit = Unit::Kpa;
    // Nothing was above 344.7 kPa.
    has(&screen(&model, 100, 14), &["scale 0 to 500.0 kPa"]);
}

/// 20x4 shows that it runs, and the selected channel.
#[test]
fn a_tiny_terminal_has_numbers() {
    let mut model = model(1, 1_000);
    let small = screen(&model, 20, 4);
    has(&small, &["1000.0 Hz 0 lost", ">0.0  100.0/344.7", "v vent  q end"]);
    model.select(3);
    has(&screen(&model, 20, 4), &[">0.3  344.0/344.7"]);
    model.session.overriding.vent();
    has(&screen(&model, 20, 4), &["VENTED"]);
    for (width, height) in [(1, 1), (1, 24), (10, 3), (30, 8), (39, 5), (61, 9), (200, 60)] {
        for boards in [0, 1, 4, 16] {
            screen(&self::model(boards, 1_000), width, height);
        }
    }
}

#[test]
fn the_selected_board_is_in_view_and_the_help_has_all_keys() {
    let mut model = model(16, 1_000);
    assert!(!screen(&model, 80, 24).contains("board 15"));
    model.select(61);
    has(&screen(&model, 80, 24), &["board 15: present", ">1 "]);
    model.help = true;
    has(&screen(&model, 80, 24), &["r, then y", "PgUp PgDn", "q Ctrl-C", "w  "]);
}

#[test]
fn events_scroll_and_stay_where_they_are_looked_at() {
    let mut model = model(1, 1_000);
    for number in 0..30 {
        model.happened(format!("event {number}."));
    }
    has(&screen(&model, 80, 12), &["event 29."]);
    model.scroll_events(10);
    model.happened("event 30.".into());
    let back = screen(&model, 80, 12);
    has(&back, &["event 19.", "(11 newer, PgDn)"]);
    assert!(!back.contains("event 29."), "{back}");
    model.scroll_events(-50);
    has(&screen(&model, 80, 12), &["event 30."]);
}

/// Above the channels, in the unit for people, as long as it is not old.
#[test]
fn the_supply_is_with_its_board() {
    let supply = Some(SupplyPressure { kpa: 549.66, measured_ns: 1_000 });
    let with_supply = |now_ns| {
        let mut model = model(1, now_ns);
        model.snapshot.boards[0].sensors = BoardSensors { supply, ..BoardSensors::default() };
        model
    };
    let mut soon = with_supply(2_000);
    has(&screen(&soon, 80, 24), &["board 0 (arm): present, supply 549.7 kPa"]);
    soon.session.setup.unit = Unit::Bar;
    has(&screen(&soon, 80, 24), &["supply 5.497 bar"]);
    assert!(!screen(&with_supply(11_000_000_000), 80, 24).contains("supply"));
    let electronics = ElectronicsReading { chip_c: Some(41.8), rail_v: None, asked_ns: 0 };
    soon.snapshot.boards[0].sensors.electronics = Some(electronics);
    has(&screen(&soon, 100, 24), &["supply 5.497 bar, chip 42 C"]);
    assert!(!screen(&soon, 80, 24).contains("chip"), "there is no room for it");
}

#[test]
fn the_line_rate_is_with_the_loop_rate_but_of_a_recording() {
    let mut model = model(1, 1_000);
    let statistics = |baud| Statistics { baud, ..Statistics::default() };
    model.statistics = Some(statistics(Some(3_000_000)));
    has(&screen(&model, 80, 24), &["1000.0 Hz  0 lost, 0 rejected  3 Mbaud  cycle"]);
    model.statistics = Some(statistics(Some(1_500_000)));
    has(&screen(&model, 80, 24), &["  1.5 Mbaud  "]);
    model.statistics = Some(statistics(None));
    assert!(!screen(&model, 80, 24).contains("Mbaud"));
}
