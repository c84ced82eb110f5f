//! Sensors on the I2C connectors of virtual boards, from the truth plant to a recording that the
//! toolkit reads. In virtual time.

use pneudrive_host::bus::BusOptions;
use pneudrive_host::line::Line;
use pneudrive_host::poller::{
    BoardSensors, Observer, Pace, PageShare, PollerOptions, Polling, Row, SourceStatus, VENTED,
};
use pneudrive_model::data::{LoadOptions, Recording, load};
use pneudrive_protocol::SensorScale;
use pneudrive_protocol::pages::{SensorPart, SensorState};
use pneudrive_record::trajectory::{AtEnd, Interpolation, Trajectory};
use pneudrive_record::{PageColumns, Recorder, RecorderOptions};
use pneudrive_sim::plant::PlantParameters;
use pneudrive_sim::rig::{Firmware, RigOptions};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use system_tests::firmware;
use system_tests::virtual_bus::{self, VirtualBus};

const SCALE: SensorScale = SensorScale::ORIGINAL;
/// Two seconds after power-up the boards obey; then the joint of board 1 is bent, and back.
const BEND: &str = "t_s,b1_cmd0_kpa,b1_cmd1_kpa\n0,0,0\n3,200,50\n4,50,200\n5,50,200\n";

/// Two boards with a supply that swings by 20 kPa every second; board 0 has no IMU.
fn rig() -> RigOptions {
    let mut plant = PlantParameters::default();
    plant.joint.free = true;
    RigOptions {
        boards: 2,
        supply_sensors: [0, 1].into(),
        imus: [1].into(),
        effects: vec!["supply_ripple:amplitude_kpa=20,period_s=1".parse().unwrap()],
        plant,
        strict: true,
        ..RigOptions::default()
    }
}

/// Time of a row, s, and what the two boards' sensors had told by then.
type Moment = (f64, [BoardSensors; 2]);

#[derive(Clone, Default)]
struct Seen(Arc<Mutex<Vec<Moment>>>);

impl Observer for Seen {
    fn row(&mut self, row: &Row<'_>) {
        let sensors = [row.boards[0].sensors, row.boards[1].sensors];
        self.0.lock().unwrap().push((row.since_start_ns as f64 * 1e-9, sensors));
    }
}

/// 5 s at 500 Hz, every second poll followed by a page.
fn bend(file: &Path) -> (Polling<VirtualBus>, Vec<Moment>) {
    let options = PollerOptions::for_devices(2)
        .pace(Pace::every(Duration::from_millis(2)))
        .sensors(PageShare::new(0.5).unwrap());
    let trajectory = Trajectory::parse("bend.csv", BEND.as_bytes(), 2, SCALE).unwrap();
    let source = trajectory.play(Interpolation::Hold, AtEnd::Stop, SCALE, vec![VENTED; 2]);
    let pages = PageColumns { drives: false, sensors: true };
    let how = RecorderOptions::default().pages(pages);
    let (recorder, tap) = Recorder::create_with(file, &options.boards, SCALE, &how).unwrap();
    let seen = Seen::default();
    let bus = virtual_bus::bus(&rig(), BusOptions::default());
    let mut polling = Polling::new(bus, options, Box::new(source), vec![tap, Box::new(seen.clone())]);
    loop {
        let due = polling.next_cycle_ns();
        polling.bus_mut().line_mut().sleep_until(due);
        if polling.cycle().unwrap() == SourceStatus::Ended {
            break;
        }
    }
    polling.finish();
    // The recorder's tap goes with it.
    let bus = polling.into_bus();
    recorder.finish().unwrap();
    let rows = seen.0.lock().unwrap().clone();
    (Polling::new(bus, PollerOptions::for_devices(2), Box::new(Nothing), Vec::new()), rows)
}

struct Nothing;

impl pneudrive_host::poller::CommandSource for Nothing {
    fn fill(&mut self, _: u64, _: &mut [pneudrive_host::poller::BoardCommand]) -> SourceStatus {
        SourceStatus::Continues
    }
}

#[test]
fn boards_measure_the_plants_supply_and_the_bending_of_their_joint() {
    let folder = tempfile::tempdir().unwrap();
    let (mut polling, rows) = bend(&folder.path().join("run.csv"));
    let bus = polling.bus_mut();
    let status = bus.sensors(1).unwrap();
    assert_eq!((status.supply, status.supply_state), (SensorPart::Ads1115, SensorState::Live));
    assert_eq!((status.imu, status.imu_state), (SensorPart::Bmi323, SensorState::Live));
    assert_eq!(bus.sensors(0).unwrap().imu, SensorPart::None);
    // Ten readings: both boards have the same supply, and noise of their own.
    for board in 0..2 {
        let supply: Vec<f64> =
            rows.iter().filter_map(|(_, s)| s[board].new_supply()).map(|supply| supply.kpa).collect();
        let (low, high) = supply.iter().fold((f64::MAX, f64::MIN), |(l, h), &kpa| (l.min(kpa), h.max(kpa)));
        assert!(supply.len() > 300, "{}", supply.len());
        assert!((528.0..534.0).contains(&low) && (566.0..573.0).contains(&high), "{low} to {high} kPa");
    }
    let together = rows.iter().filter_map(|(_, [a, b])| Some((a.supply?, b.supply?)));
    let together: Vec<_> =
        together.filter(|(a, b)| a.measured_ns.abs_diff(b.measured_ns) < 5_000_000).collect();
    assert!(together.len() > 100, "{}", together.len());
    assert!(together.iter().all(|(a, b)| (a.kpa - b.kpa).abs() < 3.0));
    assert!(together.iter().any(|(a, b)| (a.kpa - b.kpa).abs() > 0.05), "the same noise");

    assert!(rows.iter().all(|(_, sensors)| sensors[0].motion.is_none()));
    let motions: Vec<_> =
        rows.iter().filter_map(|(t_s, sensors)| Some((*t_s, sensors[1].new_motion()?))).collect();
    assert!(motions.len() > 200, "{}", motions.len());
    let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(motions.iter().all(|(_, m)| (norm(m.acceleration_m_s2) - 9.807).abs() < 0.1));
    let still: Vec<_> = motions.iter().filter(|(t_s, _)| *t_s < 2.9).collect();
    assert!(still.iter().all(|(_, m)| norm(m.angular_rate_rad_s) < 0.01 && m.acceleration_m_s2[2] > 9.7));
    // The chamber at the higher pressure lengthens: about x, one way and then the other.
    let turn = |from: f64, to: f64| {
        let within = motions.iter().filter(|(t_s, _)| (from..to).contains(t_s));
        within
            .map(|(_, m)| m.angular_rate_rad_s[0])
            .fold(0.0, |far: f64, w| if w.abs() > far.abs() { w } else { far })
    };
    assert!(turn(3.0, 3.5) > 0.1 && turn(4.0, 4.5) < -0.2, "{} {}", turn(3.0, 3.5), turn(4.0, 4.5));
    let bent = motions.iter().rfind(|(t_s, _)| *t_s < 3.99).unwrap().1.acceleration_m_s2;
    assert!(bent[1] > 0.3, "gravity along y of the bent plate: {bent:?}");
}

fn read(file: &Path) -> Recording {
    load(file, LoadOptions::default()).unwrap().recording
}

/// Read now and then, a supply is what the toolkit has in every row.
#[test]
fn a_recorded_supply_is_the_toolkits() {
    for name in ["run.csv", "run.mcap"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let (_, rows) = bend(&file);
        let recording = read(&file);
        assert_eq!(recording.board_supplies.len(), 2, "{name}");
        for board in 0..2_u8 {
            let supply = recording.supply_of(board).unwrap();
            assert!(supply.iter().all(|kpa| kpa.is_finite()), "{name}");
            let readings = rows.iter().enumerate();
            let readings: Vec<_> = readings
                .filter_map(|(row, (_, s))| Some((row, s[usize::from(board)].new_supply()?.kpa)))
                .collect();
            assert!(readings.len() > 300, "{name}");
            for (row, kpa) in readings {
                assert!((f64::from(supply[row]) - kpa).abs() < 0.01, "{name}: row {row}");
            }
        }
    }
}

/// In a bag they are ROS's own messages, too.
#[test]
fn a_bag_has_fluid_pressures_and_imus() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let (_, rows) = bend(&file);
    let bytes = std::fs::read(&file).unwrap();
    let mut topics = std::collections::BTreeMap::<String, usize>::new();
    let mut last_pa = 0.0;
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        *topics.entry(message.channel.topic.clone()).or_default() += 1;
        if message.channel.topic == "/pneudrive/joint_1/supply_pressure" {
            let schema = message.channel.schema.as_ref().unwrap();
            assert_eq!(schema.name, "sensor_msgs/msg/FluidPressure");
            let pa = &message.data[message.data.len() - 16..message.data.len() - 8];
            last_pa = f64::from_le_bytes(pa.try_into().unwrap());
        }
    }
    let count = |topic: &str| topics.get(&format!("/pneudrive/{topic}")).copied().unwrap_or(0);
    let told = |of: fn(&[BoardSensors; 2]) -> bool| rows.iter().filter(|(_, sensors)| of(sensors)).count();
    assert_eq!(count("joint_0/supply_pressure"), told(|s| s[0].new_supply().is_some()));
    assert_eq!(count("joint_1/supply_pressure"), told(|s| s[1].new_supply().is_some()));
    assert_eq!(count("joint_1/imu"), told(|s| s[1].new_motion().is_some()));
    assert!(count("joint_1/imu") > 200 && count("joint_0/imu") == 0, "{topics:?}");
    let last_kpa = rows.iter().rev().find_map(|(_, s)| s[1].new_supply()).unwrap().kpa;
    assert!(
        (last_pa - 1e3 * (last_kpa + 101.325)).abs() < 1e-6,
        "absolute: {last_pa} Pa, gauge {last_kpa} kPa"
    );
}

/// A board that lost its supply of current finds its sensors again.
#[test]
fn a_board_that_starts_anew_finds_its_sensors() {
    let faults = vec!["power_cycle@1,board=1,ms=50".parse().unwrap()];
    let mut bus = virtual_bus::bus(&RigOptions { faults, strict: false, ..rig() }, BusOptions::default());
    assert_eq!(bus.sensors(1).unwrap().supply_state, SensorState::Live);
    bus.line_mut().sleep_until(1_020_000_000);
    assert!(bus.sensors(1).is_err());
    bus.line_mut().sleep_until(1_500_000_000);
    bus.ping(1).unwrap();
    let status = bus.sensors(1).unwrap();
    assert_eq!((status.supply_state, status.imu_state), (SensorState::Live, SensorState::Live));
}

/// The real firmware with emulated parts: its drivers measure what native boards are told.
#[test]
fn emulated_chips_measure_the_plants_supply_and_gravity() {
    let effects = vec!["supply_level:change_kpa=-50".parse().unwrap()];
    let faults = vec!["power_cycle@2,board=1,ms=50".parse().unwrap()];
    let firmware = Some(Firmware::new(firmware::elf()));
    let rig = RigOptions { firmware, effects, faults, strict: false, ..rig() };
    let mut bus = virtual_bus::bus(&rig, BusOptions::default());
    bus.line_mut().sleep_until(1_500_000_000);
    for board in 0..2 {
        bus.ping(board).unwrap();
        let kpa = bus.supply(board).unwrap().0.live_kpa().unwrap();
        assert!((kpa - 500.0).abs() < 3.0, "board {board}: {kpa} kPa");
        let electronics = bus.electronics(board).unwrap().0;
        assert_eq!(electronics.rail_voltage.unwrap().volts(), 5.0);
        assert_eq!(electronics.chip_temperature.unwrap().celsius(), 27.2);
    }
    assert_eq!(bus.sensors(0).unwrap().imu, SensorPart::None);
    let [x, y, z] = bus.acceleration(1).unwrap().0.m_per_s2().unwrap();
    assert!(x.abs() < 0.1 && y.abs() < 0.1 && (z - 9.807).abs() < 0.1, "upright: {x} {y} {z}");
    assert!(bus.angular_rate(1).unwrap().0.rad_per_s().unwrap().iter().all(|w| w.abs() < 0.02));
    // The parts lose their power with the board, and are found and set up again.
    bus.line_mut().sleep_until(2_020_000_000);
    assert!(bus.sensors(1).is_err());
    bus.line_mut().sleep_until(2_500_000_000);
    bus.ping(1).unwrap();
    let status = bus.sensors(1).unwrap();
    assert_eq!((status.supply_state, status.imu_state), (SensorState::Live, SensorState::Live));
    let z = bus.acceleration(1).unwrap().0.m_per_s2().unwrap()[2];
    assert!((z - 9.807).abs() < 0.1, "{z}");
}

#[test]
fn parts_belong_to_boards_that_have_a_connector() {
    let refused = |rig: RigOptions| rig.build().err().unwrap().to_string();
    let beyond = RigOptions { boards: 2, imus: [2].into(), ..RigOptions::default() };
    assert!(refused(beyond).starts_with("no board at position 2 that can have an IMU"));
    let original = RigOptions { original: [0].into(), supply_sensors: [0].into(), ..RigOptions::default() };
    assert!(refused(original).contains("a supply sensor"));
    let all = RigOptions { boards: 3, original: [1].into(), ..RigOptions::default() }.with_all_sensors();
    assert_eq!((all.imus.clone(), all.build().is_ok()), ([0, 2].into(), true));
}
