//! Sensors on boards' I2C connectors, asked for between polls: what is asked, told and recorded. In
//! virtual time.

use crate::support::counts;
use crate::support::virtual_line::{AT_ONCE, Reply, VirtualLine};
use pneudrive_host::Calibration;
use pneudrive_host::bus::{Bus, BusOptions, EchoMode, PageError};
use pneudrive_host::line::Line;
use pneudrive_host::notices::NoticeWriter;
use pneudrive_host::poller::{
    BoardSensors, Event, Observer, Pace, PageShare, PollerOptions, Polling, Row, SetPoints,
};
use pneudrive_protocol::pages::{
    Acceleration, AngularRate, Electronics, GaugePressure, NO_SUCH_ENTRY, PageEntry, SensorEntry, SensorPart,
    SensorState, SensorStatus, SupplyReading, Temperature, Voltage,
};
use pneudrive_protocol::{Address, Asked, Echo, RequestDecoder};
use pneudrive_record::{PageColumns, Recorder, RecorderOptions};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const BOTH: SensorStatus = SensorStatus {
    supply: SensorPart::Ads1115,
    supply_state: SensorState::Live,
    imu: SensorPart::Bmi323,
    imu_state: SensorState::Live,
    errors: 0,
    recoveries: 0,
};
const SUPPLY_ALONE: SensorStatus =
    SensorStatus { imu: SensorPart::None, imu_state: SensorState::Absent, ..BOTH };

/// A board that answers polls, and what it says of its sensors; `None` if its firmware is of before
/// them.
#[derive(Clone)]
struct Board {
    status: Arc<Mutex<Option<SensorStatus>>>,
    asked: Arc<Mutex<Vec<PageEntry>>>,
    /// `None` if its firmware is of before them.
    electronics: Option<Electronics>,
}

impl Board {
    fn with(status: Option<SensorStatus>) -> Self {
        let electronics = Electronics {
            chip_temperature: Some(Temperature::from_steps(400)),
            rail_voltage: Some(Voltage::from_uv(4_980_000)),
        };
        let status = Arc::new(Mutex::new(status));
        Self { status, asked: Arc::default(), electronics: Some(electronics) }
    }

    fn script(&self) -> impl FnMut(usize, &[u8]) -> Reply + Send + use<> {
        let board = self.clone();
        let mut ear = RequestDecoder::new(Address::of_board(0));
        move |_, request| {
            let bytes = match request.iter().filter_map(|&byte| ear.push(byte)).last() {
                Some(Asked::Pressures(request)) => request.answer(ear.address(), counts(500)),
                Some(Asked::Page(request)) => {
                    let entry = request.entry().map(|entry| board.tell(entry));
                    request.answer(entry).encode()
                }
                None => return Vec::new(),
            };
            vec![(AT_ONCE, bytes.to_vec())]
        }
    }

    fn tell(&self, entry: PageEntry) -> [pneudrive_protocol::Counts; 4] {
        self.asked.lock().unwrap().push(entry);
        let Some(status) = *self.status.lock().unwrap() else { return NO_SUCH_ENTRY };
        let entry = match entry {
            PageEntry::Sensor(entry) => entry,
            PageEntry::Electronics => return self.electronics.map_or(NO_SUCH_ENTRY, Electronics::to_entry),
            _ => return NO_SUCH_ENTRY,
        };
        let live = status.imu_state == SensorState::Live;
        match entry {
            SensorEntry::Status => status.to_entry(),
            SensorEntry::Supply => SupplyReading {
                state: status.supply_state,
                age_ms: 5,
                pressure: GaugePressure::from_pa(549_660),
            }
            .to_entry(),
            SensorEntry::Acceleration if status.imu == SensorPart::None => Acceleration::ABSENT.to_entry(),
            SensorEntry::Acceleration => Acceleration::from_steps([1, -981, 0], live).to_entry(),
            SensorEntry::AngularRate => AngularRate::from_steps([400, -1, 0], live).to_entry(),
            SensorEntry::Times => NO_SUCH_ENTRY,
        }
    }

    fn count(&self, entry: PageEntry) -> usize {
        self.asked.lock().unwrap().iter().filter(|asked| **asked == entry).count()
    }
}

fn bus(board: &Board) -> Bus<VirtualLine> {
    let options = BusOptions::default().echo(EchoMode::Known(Echo::Absent)).sessions(false);
    Bus::new(VirtualLine::new(board.script()), options).unwrap()
}

/// Rows' sensors, and what people are told.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<Heard>>);

#[derive(Default)]
struct Heard {
    rows: Vec<BoardSensors>,
    narrator: NoticeWriter,
    lines: Vec<String>,
}

impl Observer for Told {
    fn row(&mut self, row: &Row<'_>) {
        self.0.lock().unwrap().rows.push(row.boards[0].sensors);
    }

    fn event(&mut self, event: &Event<'_>) {
        let Heard { narrator, lines, .. } = &mut *self.0.lock().unwrap();
        lines.extend(narrator.notice(event).map(|notice| format!("{}: {}", notice.kind.name(), notice.text)));
    }
}

impl Told {
    fn rows(&self) -> Vec<BoardSensors> {
        self.0.lock().unwrap().rows.clone()
    }

    fn lines(&self) -> Vec<String> {
        std::mem::take(&mut self.0.lock().unwrap().lines)
    }
}

struct Run {
    polling: Polling<VirtualLine>,
    told: Told,
}

impl Run {
    /// One board at 1 kHz, asked for a sensor's page after this share of the polls.
    fn start(board: &Board, share: f64, more: Option<Box<dyn Observer>>) -> Self {
        let options = PollerOptions::for_devices(1)
            .pace(Pace::every(Duration::from_millis(1)))
            .sensors(PageShare::new(share).unwrap());
        let told = Told::default();
        let mut observers: Vec<Box<dyn Observer>> = vec![Box::new(told.clone())];
        observers.extend(more);
        let polling = Polling::new(bus(board), options, Box::new(SetPoints::new(1)), observers);
        Self { polling, told }
    }

    fn poll(&mut self, cycles: usize) {
        for _ in 0..cycles {
            let at_ns = self.polling.next_cycle_ns();
            self.polling.bus_mut().line_mut().sleep_until(at_ns);
            self.polling.cycle().unwrap();
        }
    }
}

#[test]
fn a_board_tells_what_it_has_and_measures() {
    let board = Board::with(Some(BOTH));
    let mut bus = bus(&board);
    assert_eq!(bus.sensors(0).unwrap(), BOTH);
    assert_eq!(bus.supply(0).unwrap().0.live_kpa(), Some(549.66));
    assert_eq!(bus.acceleration(0).unwrap().0.m_per_s2(), Some([0.01, -9.81, 0.0]));
    assert_eq!(bus.angular_rate(0).unwrap().0.rad_per_s(), Some([1.0, -0.0025, 0.0]));
    assert_eq!(Some(bus.electronics(0).unwrap().0), board.electronics);
    *board.status.lock().unwrap() = None;
    let error = bus.supply(0).unwrap_err();
    assert!(matches!(error, PageError::NoSuchEntry { .. }), "{error}");
}

#[test]
fn a_share_of_the_polls_is_followed_by_a_page_of_what_there_is() {
    let board = Board::with(Some(BOTH));
    let mut run = Run::start(&board, 0.1, None);
    run.poll(2_000);
    // The second page of the last IMU is made up for later.
    let pages = board.asked.lock().unwrap().len();
    assert!((200..=201).contains(&pages), "{pages} pages");
    assert_eq!(run.polling.statistics().lost, 0);
    let [supply, acceleration, rate] =
        [SensorEntry::Supply, SensorEntry::Acceleration, SensorEntry::AngularRate]
            .map(|entry| board.count(PageEntry::Sensor(entry)));
    assert!(supply.abs_diff(acceleration) <= 1 && acceleration == rate, "{supply} {acceleration} {rate}");
    let rows = run.told.rows();
    let new = |of: fn(&BoardSensors) -> bool| rows.iter().filter(|sensors| of(sensors)).count();
    assert_eq!(new(|s| s.new_supply().is_some()), supply);
    assert_eq!(new(|s| s.new_motion().is_some()), rate);
    assert_eq!(new(|s| s.new_electronics().is_some()), 2);
    // What was read last stays with the row, for those who look now and then.
    let last = rows.last().unwrap();
    let (supply, motion) = (last.supply.unwrap(), last.motion.unwrap());
    assert_eq!((supply.kpa, motion.angular_rate_rad_s), (549.66, [1.0, -0.0025, 0.0]));
    let electronics = last.electronics.unwrap();
    assert_eq!((electronics.chip_c, electronics.rail_v), (Some(30.0), Some(4.98)));
    let figures = run.polling.statistics().boards[0].sensors.unwrap();
    assert_eq!((figures.supply_kpa, figures.chip_c, figures.rail_v), (Some(549.66), Some(30.0), Some(4.98)));
    assert_eq!(figures.angular_rate_rad_s, Some([1.0, -0.0025, 0.0]));
    let now_ns = run.polling.bus_mut().line().now_ns();
    assert!((5..35).contains(&supply.age(now_ns).as_millis()), "{:?}", supply.age(now_ns));
    assert_eq!(run.told.lines(), ["sensors: board 0: supply sensor ADS1115 live, IMU BMI323 live"]);
}

/// Firmware of before sensors, and of before pages: polls go on.
#[test]
fn a_board_that_does_not_tell_is_asked_once_a_second_and_told_of_once() {
    let board = Board::with(None);
    let mut run = Run::start(&board, 1.0, None);
    run.poll(3_000);
    assert_eq!(board.asked.lock().unwrap().len(), 3 + 2, "three at once, then one a second");
    let lines = run.told.lines();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].starts_with("no_sensors: board 0 does not tell its sensors ("), "{lines:?}");
    assert_eq!(run.polling.statistics().lost, 0);
    assert!(run.told.rows().iter().all(|sensors| *sensors == BoardSensors::default()));
}

/// Its sensors are asked for as before, and nobody is told.
#[test]
fn a_board_that_does_not_tell_its_electronics_is_asked_for_them_once_a_minute() {
    let board = Board { electronics: None, ..Board::with(Some(BOTH)) };
    let mut run = Run::start(&board, 0.1, None);
    run.poll(61_000);
    assert_eq!(board.count(PageEntry::Electronics), 2);
    assert_eq!(run.told.lines().len(), 1, "of its sensors");
    assert!(run.told.rows().iter().all(|sensors| sensors.electronics.is_none()));
    assert_eq!(run.polling.statistics().lost, 0);
}

/// Plugged in, broken, unplugged: each time people are told, within a second, and old readings are
/// none.
#[test]
fn parts_come_and_go() {
    let board = Board::with(Some(SensorStatus::NONE));
    let mut run = Run::start(&board, 0.1, None);
    run.poll(1_500);
    assert_eq!(run.told.lines(), ["sensors: board 0: no supply sensor, no IMU"]);
    assert_eq!(board.asked.lock().unwrap().len(), 4, "twice, and twice for its electronics");
    *board.status.lock().unwrap() = Some(SUPPLY_ALONE);
    run.poll(1_500);
    assert_eq!(run.told.lines(), ["sensors: board 0: supply sensor ADS1115 live, no IMU"]);
    assert!(run.told.rows().last().unwrap().supply.is_some());
    let broken = SensorStatus { supply_state: SensorState::OutOfRange, ..SUPPLY_ALONE };
    *board.status.lock().unwrap() = Some(broken);
    run.poll(1_100);
    assert_eq!(run.told.lines(), ["no_sensors: board 0: supply sensor ADS1115 out of range, no IMU"]);
    assert_eq!(run.told.rows().last().unwrap().supply, None);
    *board.status.lock().unwrap() = Some(SensorStatus::NONE);
    run.poll(1_100);
    assert_eq!(run.told.lines(), ["no_sensors: board 0: no supply sensor, no IMU; it had more before"]);
}

#[test]
fn a_recording_has_readings_in_the_rows_in_which_they_came() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let pages = PageColumns { drives: false, sensors: true };
    let how = RecorderOptions::default().pages(pages);
    let (recorder, tap) = Recorder::create_with(&file, &[0], Calibration::default(), &how).unwrap();
    let board = Board::with(Some(SUPPLY_ALONE));
    let mut run = Run::start(&board, 0.5, Some(tap));
    run.poll(8);
    drop(run);
    recorder.finish().unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("# event: {\"t_s\":0.0"), "{text}");
    let rows: Vec<_> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert!(rows[0].contains(",b0_p3_kpa,b0_supply_kpa,b0_ax_m_s2,"), "{text}");
    let supply: Vec<_> = rows[1..].iter().map(|row| row.split(',').nth(9).unwrap()).collect();
    assert_eq!(supply, ["", "", "549.66", "", "", "", "549.66", ""], "{text}");
    let ends: Vec<_> = rows[1..].iter().map(|row| row.ends_with(",,,,,,,30.0,4.98")).collect();
    assert_eq!(ends, [false, false, false, false, true, false, false, false], "{text}");
}
