//! The paper's table: mean and standard deviation of the loop rate over 2044 cycles for 1 to 4 boards.

use crate::cli::args::{BenchArgs, BusArgs};
use crate::cli::connect::{connect, devices, is_sim};
use crate::cli::failure::Failure;
use crate::cli::find_boards;
use crate::cli::output::print_json;
use crate::cli::signals::StopSignal;
use pneudrive_host::bus::Bus;
use pneudrive_host::line::SerialPort;
use pneudrive_host::poller::{PollerOptions, Polling, SetPoints};
use pneudrive_host::statistics::Statistics;
use serde::Serialize;

#[derive(Serialize)]
struct BenchReport {
    port: String,
    baud: u32,
    cycles: u32,
    runs: Vec<BenchRun>,
}

#[derive(Serialize)]
struct BenchRun {
    /// What the wire allows, Hz.
    wire_limit_hz: f64,
    /// Mean rate as a share of it.
    wire_share: f64,
    /// What an exchange costs beyond its wire time, us.
    overhead_us: f64,
    #[serde(flatten)]
    statistics: Statistics,
}

/// Measures 1 to `--devices` boards, on this thread, commanding 0 kPa.
pub fn run(args: &BusArgs, bench: &BenchArgs) -> Result<(), Failure> {
    let most = devices(args, 4)?;
    let stop = StopSignal::install()?;
    SerialPort::precise_sleeps();
    let mut report =
        BenchReport { port: String::new(), baud: args.baud, cycles: bench.cycles, runs: Vec::new() };
    let mut table_started = false;
    for boards in 1..=most {
        let connection = connect(args, boards)?;
        report.port =
            if is_sim(args) { "sim".to_owned() } else { connection.bus.line().path().display().to_string() };
        if !table_started && !args.json {
            print_header(&report);
            table_started = true;
        }
        let run = measure(connection.bus, args.wait, boards, bench.cycles, &stop)?;
        if !args.json {
            print_row(&run);
        }
        report.runs.push(run);
        if stop.came() {
            return Err(Failure::running("interrupted"));
        }
    }
    if args.json { print_json(&report) } else { Ok(()) }
}

fn measure(
    mut bus: Bus,
    wait_s: f64,
    boards: u16,
    cycles: u32,
    stop: &StopSignal,
) -> Result<BenchRun, Failure> {
    let options = PollerOptions::for_devices(boards);
    let silent = find_boards::find(&mut bus, &options.boards, wait_s, || stop.came())?;
    if let Some((board, error)) = silent.first() {
        return Err(Failure::running(format!(
            "board {board} is missing, so this would measure something else: {error}"
        )));
    }
    let baud = bus.options().baud;
    let wire_limit_hz = baud.cycle_limit_hz(u32::from(boards));
    let mut polling = Polling::new(bus, options, Box::new(SetPoints::new(usize::from(boards))), Vec::new());
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
    polling.make_safe().map_err(Failure::running)?;
    let exchange_us = 1e6 / statistics.loop_hz.mean / f64::from(boards);
    Ok(BenchRun {
        wire_limit_hz,
        wire_share: statistics.loop_hz.mean / wire_limit_hz,
        overhead_us: exchange_us - baud.exchange_ns() as f64 * 1e-3,
        statistics,
    })
}

fn wait_until(line: &mut SerialPort, due_ns: u64) {
    use pneudrive_host::line::Line as _;
    if line.now_ns() < due_ns {
        line.sleep_until(due_ns);
    }
}

fn print_header(report: &BenchReport) {
    println!(
        "{} at {} baud, {} cycles each; loop rate in Hz, cycle time in us",
        report.port, report.baud, report.cycles
    );
    println!(
        "boards  wire limit       mean +- std   share      p50     p99   p99.9     max    lost  rejected  CPU  us/exchange"
    );
}

fn print_row(run: &BenchRun) {
    let Statistics { devices, loop_hz, cycle_us, lost, rejected, cpu_share, .. } = &run.statistics;
    println!(
        "{devices:>6}  {:>10.1}  {:>8.1} +- {:<6.1} {:>5.1} %  {:>7.0} {:>7.0} {:>7.0} {:>7.0}  {lost:>6}  {rejected:>8}  {:>2.0} %  {:>11.1}",
        run.wire_limit_hz,
        loop_hz.mean,
        loop_hz.std,
        100.0 * run.wire_share,
        cycle_us.p50,
        cycle_us.p99,
        cycle_us.p999,
        cycle_us.max,
        100.0 * cpu_share,
        1e6 / loop_hz.mean / *devices as f64,
    );
}
