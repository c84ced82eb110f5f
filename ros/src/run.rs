//! From settings to a node that runs until it is told to stop.

use crate::args::{MessageType, Settings};
use crate::bus::{OpenBus, RunningBus};
use crate::diagnostic_msgs::DiagnosticArray;
use crate::diagnostics::BusReport;
use crate::failure::Failure;
use crate::live::Live;
use crate::node::{Joint, RosNode};
use crate::pressure::PressureMessage;
use crate::rosout::Rosout;
use crate::sensors::{self, SensorTap};
use crate::services::Target;
use crate::unix_time::unix_now_ns;
use crate::{parameters, publish};
use pneudrive_host::line::Clock;
use pneudrive_host::notices::{Notice, NoticeKind};
use pneudrive_host::poller::{Conclusion, Observer};
use pneudrive_host::rig::Rig;
use pneudrive_record::messages::FluidPressure;
use pneudrive_record::messages::{Header, JointState, Pressures, Time};
use pneudrive_record::{Description, PageColumns, RecordedBus, Recorder, RecorderOptions};
use ros2_client::Publisher;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the node looks whether it is to stop, and whether commands have run out.
const ATTENTION: Duration = Duration::from_millis(20);

/// Runs the node until a signal, or until a bus fails. Boards are left safe either way.
pub fn run(settings: &Settings) -> Result<(), Failure> {
    match settings.message {
        MessageType::JointState => run_with::<JointState>(settings),
        MessageType::FluidPressure => run_with::<FluidPressure>(settings),
        MessageType::Pressures { .. } => run_with::<Pressures>(settings),
    }
}

fn run_with<M: PressureMessage>(settings: &Settings) -> Result<(), Failure> {
    if let Some(path) = &settings.flags.record {
        Recorder::check_bag(path, settings.flags.overwrite)?;
    }
    let stop = stop_signal()?;
    let live = parameters::start(settings);
    let opened = open(settings)?;
    let mut node = RosNode::new(settings, &live)?;
    let diagnostics = node.diagnostics(settings)?;
    let rosout = Rosout::new(node.rosout()?, &settings.names);
    let (recorder, mut taps) = record(settings, &opened)?;
    let notes = recorder.as_ref().map(Recorder::notes).unwrap_or_default();
    let mut buses = Vec::new();
    let mut publishers: Vec<JoinHandle<()>> = Vec::new();
    let mut joints = Vec::new();
    for (index, bus) in opened.into_iter().enumerate() {
        let names = bus.names().to_vec();
        let topics = names.iter().map(|joint| node.states::<M>(settings, joint, index));
        let topics: Vec<Vec<_>> = topics.collect::<Result<_, _>>()?;
        let mut more: Vec<_> = taps.next().into_iter().collect();
        if settings.flags.sensors.is_some() {
            let topics = names.iter().map(|joint| node.sensors(settings, joint.joint()));
            let topics: Vec<_> = topics.collect::<Result<_, _>>()?;
            let (tap, readings) = SensorTap::new();
            more.push(Box::new(tap));
            let ambient_kpa = sensors::ambient_kpa(settings.rig.as_ref());
            publishers
                .push(publisher("pneudrive-sens", move || sensors::run(topics, &readings, ambient_kpa))?);
        }
        let (bus, states) = bus.start(&live, more, notes.clone())?;
        joints.extend(
            names
                .iter()
                .zip(&bus.gates)
                .map(|(names, gate)| Joint { number: names.joint(), gate: Arc::clone(gate) }),
        );
        let counters = Arc::clone(&bus.published);
        publishers.push(publisher("pneudrive-pub", move || publish::run(topics, &states, &counters))?);
        buses.push(bus);
    }
    announce(settings, &buses);
    let target = Target {
        latches: buses.iter().map(|bus| bus.vent.clone()).collect(),
        gates: buses.iter().flat_map(|bus| bus.gates.iter().cloned()).collect(),
    };
    let listener = node.listen::<M>(settings, joints, Arc::clone(&live), target)?;
    attend(settings, &stop, &live, &buses, &diagnostics, || {
        rosout.publish();
        recorder.as_ref().is_some_and(Recorder::has_failed)
    });
    // Boards first.
    let ended = leave_safe(buses);
    for publisher in publishers {
        let _ = publisher.join();
    }
    rosout.publish();
    drop((diagnostics, rosout));
    listener.stop();
    if let Some(recorder) = recorder {
        let reason = if ended.is_ok() { "signal: the node was told to stop" } else { "line: a bus failed" };
        recorder.notes().add(Notice::new(NoticeKind::End, reason));
        let summary = recorder.finish()?;
        log::info!("{}: {} rows, {} bytes", summary.file.display(), summary.rows, summary.bytes);
    }
    ended
}

/// A thread that publishes.
fn publisher(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, Failure> {
    let thread = std::thread::Builder::new().name(name.into());
    thread.spawn(work).map_err(|error| Failure::running(format!("no thread to publish: {error}")))
}

/// Set by SIGINT, SIGTERM or SIGHUP. A second signal ends the process at once, in case something
/// hangs.
fn stop_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // The order matters: the first signal finds the flag unset.
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&stop))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| Failure::running(format!("cannot handle signals: {error}")))?;
    }
    Ok(stop)
}

fn open(settings: &Settings) -> Result<Vec<OpenBus>, Failure> {
    let mut first_joint = settings.flags.first_joint;
    (0..settings.flags.port.len())
        .map(|index| {
            let bus = OpenBus::open(settings, index, first_joint)?;
            first_joint += settings.devices(index);
            Ok(bus)
        })
        .collect()
}

type Taps = std::vec::IntoIter<Box<dyn Observer>>;

fn record(settings: &Settings, buses: &[OpenBus]) -> Result<(Option<Recorder>, Taps), Failure> {
    let Some(path) = &settings.flags.record else { return Ok((None, Vec::new().into_iter())) };
    let unix_offset_ns = Clock.unix_offset_ns();
    let recorded: Vec<_> = buses
        .iter()
        .map(|bus| RecordedBus {
            boards: bus.boards().to_vec(),
            first_joint: bus.first_joint(),
            unix_offset_ns,
        })
        .collect();
    let prefix = settings.names.full();
    let options = RecorderOptions::default()
        .overwrite(settings.flags.overwrite)
        .pages(PageColumns { drives: false, sensors: settings.flags.sensors.is_some() })
        .ambient_kpa(settings.rig.as_ref().and_then(Rig::ambient_kpa))
        .description(description(settings));
    let (recorder, taps) =
        Recorder::create_bag_with(path, &prefix, &recorded, settings.calibration.clone(), &options)?;
    Ok((Some(recorder), taps.into_iter()))
}

/// What the recording says of itself.
fn description(settings: &Settings) -> Description {
    let command_line: Vec<_> = std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect();
    let ports: Vec<_> = settings.flags.port.iter().map(|port| port.to_string_lossy().into_owned()).collect();
    let description = Description::default()
        .with("program", concat!("pneudrive-ros ", env!("CARGO_PKG_VERSION")))
        .with("command_line", command_line)
        .with("port", ports);
    match &settings.rig {
        Some(rig) => description.with("rig_file", rig.file()).with("rig", rig.text()),
        None => description,
    }
}

fn announce(settings: &Settings, buses: &[RunningBus]) {
    for bus in buses {
        let last = bus.first_joint as usize + bus.gates.len().saturating_sub(1);
        let name = settings.names.full();
        log::info!(
            "{name}: joint_{} to joint_{last} on {}, DDS domain {}",
            bus.first_joint,
            bus.port,
            settings.domain_id
        );
    }
}

/// Until it is time to end: vents joints whose commands have run out, and says how things are.
/// Should this thread get stuck, the buses' threads vent after `watchdog_s`; then commands older
/// than that are not taken up again.
fn attend(
    settings: &Settings,
    stop: &AtomicBool,
    live: &Live,
    buses: &[RunningBus],
    diagnostics: &Publisher<DiagnosticArray>,
    failed: impl Fn() -> bool,
) {
    let period = Duration::from_secs_f64(settings.flags.diagnostics_period_s);
    let mut reports: Vec<_> = buses.iter().map(|_| BusReport::default()).collect();
    let mut reported = Instant::now();
    let mut attended = Instant::now();
    let mut vented = vec![false; buses.len()];
    let watchdog_ns = (settings.flags.watchdog_s * 1e9).round() as u64;
    let name = settings.names.full();
    loop {
        let ending =
            stop.load(Ordering::Relaxed) || buses.iter().any(|bus| bus.poller.is_finished()) || failed();
        let now_ns = unix_now_ns();
        let stuck_s = std::mem::replace(&mut attended, Instant::now()).elapsed().as_secs_f64();
        if watchdog_ns > 0 && stuck_s > settings.flags.watchdog_s {
            log::warn!(
                "the node was stuck for {stuck_s:.1} s: joints were vented until they are commanded again"
            );
            for gate in buses.iter().flat_map(|bus| &bus.gates) {
                gate.expire(now_ns, watchdog_ns);
            }
        }
        buses.iter().for_each(|bus| bus.set_points.renew());
        for (gate, number) in buses.iter().flat_map(|bus| bus.gates.iter().zip(bus.first_joint..)) {
            if gate.expire(now_ns, live.command_timeout_ns()) {
                log::warn!("joint_{number}: no command for too long: 0 kPa until the next one");
            }
        }
        for (bus, was_vented) in buses.iter().zip(&mut vented) {
            let is_vented = bus.vent.is_vented();
            if is_vented != std::mem::replace(was_vented, is_vented) {
                let port = &bus.port;
                match is_vented {
                    true => log::warn!("{port}: vented: 0 kPa is commanded until ~/release is called"),
                    false => log::info!("{port}: released: commands from now on are followed"),
                }
            }
        }
        if ending || reported.elapsed() >= period {
            reported = Instant::now();
            let header = Header { stamp: Time::from_unix_ns(now_ns), frame_id: String::new() };
            let status =
                buses.iter().zip(&mut reports).enumerate().filter_map(|(index, (bus, report))| {
                    report.statuses(&format!("{name}: bus{index}"), bus)
                });
            let status = status.flatten().collect();
            // Who does not read diagnostics cannot stop the node.
            let _ = diagnostics.publish(DiagnosticArray { header, status });
        }
        if ending {
            return;
        }
        std::thread::sleep(ATTENTION);
    }
}

/// Ends all buses: 0 kPa to every board.
fn leave_safe(buses: Vec<RunningBus>) -> Result<(), Failure> {
    let mut ended = Ok(());
    for bus in buses {
        let RunningBus { poller, port, first_joint, watch, virtual_boards, .. } = bus;
        let finished = poller.stop();
        if let Some(watch) = watch {
            watch.finish();
        }
        drop(virtual_boards);
        let finished = match finished {
            Ok(finished) => finished,
            Err(error) => {
                ended = Err(Failure::running(format!("{port}: {error}; see above")));
                continue;
            }
        };
        let Conclusion { failures, remark, .. } =
            finished.conclusion_of("joint(s)", |board| (first_joint + u16::from(board)).to_string());
        for text in failures.iter().chain(&remark) {
            log::warn!("{port}: {text}");
        }
        if let Some(first) = failures.first() {
            ended = Err(Failure::running(format!("{port}: {first}")));
        }
    }
    ended
}
