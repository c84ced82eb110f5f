use crate::args::{BusArgs, PingArgs};
use crate::connect::{connect, devices, is_sim};
use crate::failure::Failure;
use crate::find_boards;
use crate::output::print_json;
use crate::output::{out, outln};
use crate::setup::Setup;
use crate::signals::StopSignal;
use pneudrive_host::Calibration;
use pneudrive_host::bus::{BoardFormat, Bus, ExchangeError};
use pneudrive_protocol::Echo;
use serde::Serialize;

#[derive(Serialize)]
struct PingReport {
    port: String,
    echo: bool,
    boards: Vec<BoardReport>,
}

#[derive(Serialize)]
struct BoardReport {
    board: u8,
    asked: u32,
    answered: u32,
    frames: BoardFormat,
    /// Time from request to answer: fastest, median, slowest, us.
    round_trip_us: Option<[f64; 3]>,
    pressures_kpa: Option<[f64; 4]>,
    error: Option<String>,
}

/// Asks each board some times, until Ctrl-C, and prints how it answered. Fails if any board that
/// was asked did not answer at all.
pub fn run(args: &BusArgs, ping: &PingArgs, setup: &Setup) -> Result<(), Failure> {
    let devices = devices(args, 1)?;
    args.real_time().check()?;
    let mut connection = connect(args, devices, &setup.calibration)?;
    args.real_time().apply()?;
    let bus = &mut connection.bus;
    let boards: Vec<u8> = (0..=u8::MAX).take(usize::from(devices)).collect();
    let stop = StopSignal::install(false)?;
    find_boards::find(bus, &boards, args.wait, || stop.came())?;
    let measure = |&board: &u8| measure(bus, board, ping.count, &setup.calibration, &stop);
    let boards: Vec<_> = boards.iter().map(measure).filter(|board| board.asked > 0).collect();
    for board in &boards {
        // A line that has failed is in the board's own entry.
        let _ = bus.leave(board.board);
    }
    let missing = boards.iter().filter(|board| board.answered == 0).count();
    let report = PingReport {
        port: bus.line().path().display().to_string(),
        echo: bus.echo() == Echo::Present,
        boards,
    };
    if args.json {
        print_json(&report)?
    } else {
        print(&report, is_sim(args), setup)
    }
    match missing {
        0 => Ok(()),
        _ => Err(Failure::running(format!("{missing} of {devices} boards did not answer"))),
    }
}

fn measure(
    bus: &mut Bus,
    board: u8,
    count: u32,
    calibration: &Calibration,
    stop: &StopSignal,
) -> BoardReport {
    let mut asked = 0;
    let mut times_us = Vec::new();
    let mut last = None;
    let mut error = None;
    while asked < count && !stop.came() {
        asked += 1;
        match bus.ping(board) {
            Ok(answer) => {
                times_us.push(answer.round_trip().as_nanos() as f64 * 1e-3);
                last = Some(calibration.kpa(board, answer.pressures));
            }
            Err(refused) => {
                let gone = matches!(refused, ExchangeError::Line(_));
                error = Some(refused.to_string());
                if gone {
                    break;
                }
            }
        }
    }
    times_us.sort_by(f64::total_cmp);
    let round_trip_us = match times_us[..] {
        [] => None,
        [first, .., last] => Some([first, times_us[times_us.len() / 2], last]),
        [only] => Some([only; 3]),
    };
    let answered = times_us.len() as u32;
    BoardReport {
        board,
        asked,
        answered,
        frames: bus.format(board),
        round_trip_us,
        pressures_kpa: last,
        error,
    }
}

fn print(report: &PingReport, is_sim: bool, setup: &Setup) {
    let PingReport { port, echo, .. } = report;
    let port = if is_sim { format!("sim (virtual boards on {port})") } else { port.clone() };
    outln!("port {port}{}", if *echo { ", echoes what it sends" } else { "" });
    for board in &report.boards {
        out!("{}: {} of {} answered", setup.board(board.board), board.answered, board.asked);
        if let (Some([first, median, last]), Some(kpa)) = (board.round_trip_us, board.pressures_kpa) {
            out!(", {first:.0} / {median:.0} / {last:.0} us (fastest, median, slowest)");
            let numbers = kpa.map(|kpa| setup.unit.number(kpa)).join(" ");
            out!(", {numbers} {}", setup.unit.name());
        }
        outln!(
            "{}",
            match board.frames {
                BoardFormat::Unknown => "",
                BoardFormat::Checked => ", checked packets",
                BoardFormat::Unchecked => ", original packets",
            }
        );
        if let Some(error) = &board.error {
            outln!("  last error: {error}");
        }
    }
}
