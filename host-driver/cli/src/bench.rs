//! The paper's table: mean and standard deviation of the loop rate over 2044 cycles for 1 to 4
//! boards.

use crate::args::{BenchArgs, BusArgs};
use crate::bench_table;
use crate::connect::{Connection, connect_for_measurement, devices, is_sim};
use crate::failure::Failure;
use crate::find_boards;
use crate::load::{Load, LoadMeter};
use crate::original_client::{ORIGINAL_CLIENT, OriginalClient};
use crate::output::out;
use crate::output::print_json;
use crate::signals::StopSignal;
use pneudrive_host::bus::Bus;
use pneudrive_host::line::SerialPort;
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints};
use pneudrive_host::real_time::RealTime;
use pneudrive_host::statistics::{HistogramBin, Statistics};
use pneudrive_protocol::{Baud, CHANNELS, Counts};
use pneudrive_virtual::VirtualBoards;
use serde::Serialize;

/// Exchanges before what is measured: in them the bus learns how soon boards answer, and which way
/// of waiting suits the machine.
const WARM_UP: usize = 1300;

#[derive(Serialize)]
struct BenchReport {
    port: String,
    baud: u32,
    cycles: u32,
    #[serde(flatten)]
    real_time: Scheduling,
    /// What the original client reached, to stand beside the runs.
    original: Option<OriginalClient>,
    runs: Vec<BenchRun>,
}

#[derive(Serialize)]
struct Scheduling {
    realtime_priority: Option<u8>,
    memory_locked: bool,
    core: Option<usize>,
}

#[derive(Serialize)]
pub(super) struct BenchRun {
    /// What the wire allows, Hz.
    pub(super) wire_limit_hz: f64,
    /// Mean rate as a share of it.
    pub(super) wire_share: f64,
    /// What an exchange costs beyond its wire time, us.
    overhead_us: f64,
    /// What virtual boards dated requests back by, us.
    pub(super) dated_back_us: Option<f64>,
    /// What else the computer did.
    #[serde(flatten)]
    pub(super) load: Load,
    /// Times from request to answer: counts in bins evenly spaced on a logarithmic scale.
    pub(super) round_trip_us: Vec<HistogramBin>,
    #[serde(flatten)]
    pub(super) statistics: Statistics,
}

/// Measures 1 to `--devices` boards, commanding 0 kPa.
pub fn run(args: &BusArgs, bench: &BenchArgs) -> Result<(), Failure> {
    #[cfg(feature = "web")]
    if bench.web {
        return super::web::bench::run(args, bench);
    }
    let most = devices(args, 4)?;
    let real_time = args.real_time();
    real_time.check()?;
    let stop = StopSignal::install(false)?;
    let RealTime { priority, lock_memory, core, .. } = real_time;
    let mut report = BenchReport {
        port: String::new(),
        baud: args.baud(),
        cycles: bench.cycles,
        real_time: Scheduling { realtime_priority: priority, memory_locked: lock_memory, core },
        original: (args.baud() == Baud::ORIGINAL.get()).then_some(ORIGINAL_CLIENT),
        runs: Vec::new(),
    };
    for boards in 1..=most {
        let Connection { bus, virtual_boards } = connect_for_measurement(args, boards, bench.dated)?;
        report.port = if is_sim(args) { "sim".to_owned() } else { bus.line().path().display().to_string() };
        if report.runs.is_empty() && !args.json {
            bench_table::print_header(&report.port, report.baud, report.cycles);
        }
        // A thread of its own, because the virtual boards would inherit what it asks of the
        // scheduler.
        let measured = std::thread::scope(|scope| {
            let body = || {
                SerialPort::precise_sleeps();
                real_time.apply()?;
                measure(bus, args.wait, boards, bench.cycles, &stop)
            };
            scope.spawn(body).join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        let dated_back_us = virtual_boards
            .as_ref()
            .and_then(VirtualBoards::dated_back)
            .map(|duration| duration.as_nanos() as f64 * 1e-3);
        let run = BenchRun { dated_back_us, ..measured? };
        if !args.json {
            bench_table::print_row(&run);
        }
        report.runs.push(run);
        if stop.came() {
            return Err(Failure::running("interrupted"));
        }
    }
    if args.json {
        return print_json(&report);
    }
    out!("{}", bench_table::below(&report.runs, report.original.as_ref()));
    Ok(())
}

fn measure(
    mut bus: Bus,
    wait_s: f64,
    boards: u16,
    cycles: u32,
    stop: &StopSignal,
) -> Result<BenchRun, Failure> {
    // A port that vanishes is no result.
    let options = PollerOptions::for_devices(boards).reopen(None);
    let silent = find_boards::find(&mut bus, &options.boards, wait_s, || stop.came())?;
    if let Some((board, error)) = silent.first() {
        return Err(Failure::running(format!(
            "board {board} is missing, so this would measure something else: {error}"
        )));
    }
    for n in 0..WARM_UP {
        // Lost ones show in what is measured too.
        let _ = bus.exchange(options.boards[n % options.boards.len()], [Counts::ATMOSPHERE; CHANNELS]);
    }
    let baud = bus.options().baud;
    let wire_limit_hz = baud.cycle_limit_hz(u32::from(boards));
    let mut polling = Polling::new(bus, options, Box::new(SetPoints::new(usize::from(boards))), Vec::new());
    let meter = LoadMeter::begin();
    for _ in 0..cycles {
        if stop.came() {
            break;
        }
        let due_ns = polling.next_cycle_ns();
        let line = polling.bus_mut().line_mut();
        wait_until(line, due_ns);
        polling.cycle().map_err(Failure::running)?;
    }
    let statistics = polling.finish();
    let load = meter.load();
    let round_trip_us = polling.round_trips();
    // Nothing but 0 kPa was ever commanded, so whoever answers holds nothing of this host's.
    polling.make_safe().map_err(Failure::running)?;
    let exchange_us = 1e6 / statistics.loop_hz.mean / f64::from(boards);
    Ok(BenchRun {
        wire_limit_hz,
        wire_share: statistics.loop_hz.mean / wire_limit_hz,
        overhead_us: exchange_us - baud.exchange_ns() as f64 * 1e-3,
        dated_back_us: None,
        load,
        round_trip_us,
        statistics,
    })
}

fn wait_until(line: &mut SerialPort, due_ns: u64) {
    use pneudrive_host::line::Line as _;
    if line.now_ns() < due_ns {
        line.sleep_until(due_ns);
    }
}
