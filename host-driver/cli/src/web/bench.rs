//! What a page that is being watched costs the bus: pairs of runs, without and with it.

use crate::args::{BenchArgs, BusArgs};
use crate::connect::{Connection, connect, devices};
use crate::failure::Failure;
use crate::find_boards;
use crate::output::print_json;
use crate::page::{Labels, Listener, Server, WebOptions};
use crate::signals::StopSignal;
use pneudrive_host::Calibration;
use pneudrive_host::bus::Bus;
use pneudrive_host::poller::{
    BoardCommand, CommandSource, Override, Poller, PollerOptions, SourceStatus, VENTED,
};
use pneudrive_host::statistics::Statistics;
use serde::Serialize;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::thread::JoinHandle;
use std::time::Duration;

/// Commands 0 kPa for some cycles.
struct Counted {
    left: u32,
}

impl CommandSource for Counted {
    fn fill(&mut self, _since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        commands.fill(VENTED);
        self.left = self.left.saturating_sub(1);
        if self.left == 0 { SourceStatus::Ended } else { SourceStatus::Continues }
    }
}

/// A pair.
#[derive(Debug, Serialize)]
struct Pair {
    without: Statistics,
    with: Statistics,
    /// Pictures that the client got, per second.
    pictures_hz: f64,
}

#[derive(Debug, Serialize)]
struct Report {
    cycles: u32,
    pairs: Vec<Pair>,
    /// Relative change of the mean loop rate, percent: mean over the pairs and its standard error.
    loop_hz_change_percent: [f64; 2],
    /// Relative change of the median cycle time, percent: mean over the pairs and its standard
    /// error.
    median_cycle_change_percent: [f64; 2],
    /// Relative change of the bus thread's CPU time for a cycle, percent: mean over the pairs and
    /// its standard error.
    cpu_change_percent: [f64; 2],
}

/// Measures all `--devices` boards, without and with the page in turn, on one connection.
pub fn run(args: &BusArgs, bench: &BenchArgs) -> Result<(), Failure> {
    let devices = devices(args, 4)?;
    let stop = StopSignal::install(false)?;
    let mut pairs = Vec::new();
    for number in 0..bench.pairs {
        // Whatever changes with time comes first in one pair and second in the next.
        let page_first = number % 2 == 1;
        let (first, pictures_first) = measure(args, devices, bench.cycles, page_first, &stop)?;
        let (second, pictures_second) = measure(args, devices, bench.cycles, !page_first, &stop)?;
        let (without, with) = if page_first { (second, first) } else { (first, second) };
        let pair = Pair { without, with, pictures_hz: pictures_first.max(pictures_second) };
        if !args.json {
            print_pair(number, &pair);
        }
        pairs.push(pair);
    }
    let change = |of: fn(&Pair) -> f64| mean_and_error(&pairs.iter().map(of).collect::<Vec<_>>());
    let rates = change(|pair| 100.0 * (pair.with.loop_hz.mean / pair.without.loop_hz.mean - 1.0));
    let medians = change(|pair| 100.0 * (pair.with.cycle_us.p50 / pair.without.cycle_us.p50 - 1.0));
    let cpu = change(|pair| 100.0 * (cpu_us(&pair.with) / cpu_us(&pair.without) - 1.0));
    if args.json {
        return print_json(&Report {
            cycles: bench.cycles,
            pairs,
            loop_hz_change_percent: rates,
            median_cycle_change_percent: medians,
            cpu_change_percent: cpu,
        });
    }
    println!("change with a watched page, mean +- standard error of {} pairs:", bench.pairs);
    println!("  loop rate                   {:+.2} +- {:.2} %", rates[0], rates[1]);
    println!("  median cycle                {:+.2} +- {:.2} %", medians[0], medians[1]);
    println!("  bus thread, CPU of a cycle  {:+.2} +- {:.2} %", cpu[0], cpu[1]);
    Ok(())
}

fn measure(
    args: &BusArgs,
    devices: u16,
    cycles: u32,
    watched: bool,
    stop: &StopSignal,
) -> Result<(Statistics, f64), Failure> {
    let Connection { mut bus, virtual_boards } = connect(args, devices, &Calibration::default())?;
    let options = PollerOptions::for_devices(devices);
    let silent = find_boards::find(&mut bus, &options.boards, args.wait, || stop.came())?;
    if let Some((board, error)) = silent.first() {
        return Err(Failure::running(format!("board {board} is missing: {error}")));
    }
    let (poller, page) = start(bus, options, cycles, watched)?;
    while !poller.is_finished() && !stop.came() {
        std::thread::sleep(Duration::from_millis(20));
    }
    let finished = poller.stop()?;
    drop(virtual_boards);
    let pictures = match page {
        Some((server, watcher)) => {
            server.end(None);
            watcher.join().map_err(|_| Failure::running("the watching client panicked; see above"))?
        }
        None => 0,
    };
    if let Some(error) = finished.error {
        return Err(Failure::running(error));
    }
    if stop.came() {
        return Err(Failure::running("interrupted"));
    }
    let seconds = finished.statistics.seconds;
    Ok((finished.statistics, pictures as f64 / seconds))
}

type Page = (Server, JoinHandle<u64>);

/// A poller, and with `watched` its page and a client that reads all of it.
fn start(
    bus: Bus,
    options: PollerOptions,
    cycles: u32,
    watched: bool,
) -> Result<(Poller, Option<Page>), Failure> {
    let clock = bus.line().clock();
    let boards = options.boards.clone();
    let source = Box::new(Counted { left: cycles });
    let poller = Poller::start(bus, options, source, Vec::new())?;
    if !watched {
        return Ok((poller, None));
    }
    let failed = |error: std::io::Error| Failure::running(format!("the page: {error}"));
    let listener = Listener::bind(([127, 0, 0, 1], 0).into()).map_err(failed)?;
    let address = listener.address();
    let web = WebOptions {
        port: "bench".into(),
        overriding: Some(Override::following(boards.len())),
        boards,
        labels: Labels::default(),
        calibration: Calibration::default(),
        names: Vec::new(),
        control: None,
        recording: None,
        whole_run: None,
        watch: None,
        lines: None,
        notice: Box::new(|_| {}),
    };
    let server = listener.serve(web, poller.monitor(), clock).map_err(failed)?;
    let mut stream = TcpStream::connect(address).map_err(failed)?;
    write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").map_err(failed)?;
    let watcher = std::thread::spawn(move || {
        let lines = BufReader::new(stream).lines().map_while(Result::ok);
        lines.filter(|line| line == "event: picture").count() as u64
    });
    Ok((poller, Some((server, watcher))))
}

/// CPU time of the bus thread for a cycle, us.
fn cpu_us(run: &Statistics) -> f64 {
    1e6 * run.cpu_share * run.seconds / run.cycles as f64
}

fn mean_and_error(values: &[f64]) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    [mean, (squares / (count - 1.0) / count).sqrt()]
}

fn print_pair(number: u32, pair: &Pair) {
    if number == 0 {
        println!("pair     page   mean +- std, Hz    p50, us   p99, us  lost  CPU, us/cycle  pictures/s");
    }
    for (page, run, pictures) in [("without", &pair.without, 0.0), ("with", &pair.with, pair.pictures_hz)] {
        println!(
            "{:>4}  {page:>7}  {:>7.1} +- {:<6.1}  {:>8.0}  {:>8.0}  {:>4}  {:>13.1}  {pictures:>10.1}",
            number + 1,
            run.loop_hz.mean,
            run.loop_hz.std,
            run.cycle_us.p50,
            run.cycle_us.p99,
            run.lost,
            cpu_us(run),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_its_standard_error() {
        // Squares of deviations 4 + 0 + 4 = 8, variance 4, error of the mean sqrt(4/3).
        let [mean, error] = mean_and_error(&[1.0, 3.0, 5.0]);
        assert!((mean - 3.0).abs() < 1e-12 && (error - (4.0f64 / 3.0).sqrt()).abs() < 1e-12);
    }
}
