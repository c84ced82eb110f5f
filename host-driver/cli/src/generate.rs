//! `generate`: a trajectory as a table.

use crate::args::{BusArgs, GenerateArgs, ShapeArg};
use crate::connect::devices;
use crate::failure::Failure;
use crate::limits::LimitArgs;
use crate::output::{errln, put};
use crate::setup::Setup;
use pneudrive_protocol::CHANNELS;
use pneudrive_record::trajectory::{Plan, Shape};
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::{ErrorKind, Write as _};

/// Writes the table. No file is replaced.
pub fn run(args: &BusArgs, generate: &GenerateArgs, setup: &Setup) -> Result<(), Failure> {
    if generate.low >= generate.high {
        return Err(Failure::input("--low must be below --high"));
    }
    let devices = devices(args, 1)?;
    let limits = LimitArgs::default().limits(setup.rig.as_ref())?;
    let boards: Vec<u8> = (0..=u8::MAX).take(usize::from(devices)).collect();
    let scales = boards.iter().flat_map(|&board| setup.calibration.of(board));
    let top = scales.map(|scale| scale.full_scale_kpa()).fold(0.0, f64::max);
    if generate.high > top {
        return Err(Failure::input(format!(
            "--high {}: the highest set point is {top:.1} kPa",
            generate.high
        )));
    }
    let mut channels = Vec::new();
    for &board in &boards {
        for channel in 0..CHANNELS {
            let full_scale = setup.calibration.channel(board, channel).full_scale_kpa();
            let high = generate.high.min(limits.of(board)[channel].max_kpa).min(full_scale);
            if high <= generate.low {
                return Err(Failure::input(format!(
                    "--low {}: channel {channel} of board {board} ends at {high:.1} kPa",
                    generate.low
                )));
            }
            channels.push((generate.low, high));
        }
    }
    let shape = match generate.shape {
        ShapeArg::Steps => Shape::Steps,
        ShapeArg::Sine => Shape::Sine,
        ShapeArg::Sweep => Shape::Sweep,
        ShapeArg::Aprbs => Shape::Aprbs,
    };
    let plan = Plan {
        shape,
        seconds: generate.seconds,
        channels,
        hold_s: generate.hold,
        last_period_s: generate.last_period,
        seed: generate.seed,
    };
    let text = table(&boards, &plan);
    let Some(file) = generate.file.as_ref().filter(|file| file.as_os_str() != "-") else {
        put(format_args!("{text}"));
        return Ok(());
    };
    let refused = |error: std::io::Error| {
        let why = match error.kind() {
            ErrorKind::AlreadyExists => {
                "exists and is not replaced; move it away, or choose another name".to_owned()
            }
            ErrorKind::NotFound => "cannot be created: there is no such folder".to_owned(),
            _ => format!("cannot be written: {error}"),
        };
        Failure::input(format!("{}: {why}", file.display()))
    };
    let mut writer = OpenOptions::new().write(true).create_new(true).open(file).map_err(refused)?;
    writer.write_all(text.as_bytes()).map_err(refused)?;
    errln!("{}: {} s for {devices} board(s)", file.display(), generate.seconds);
    Ok(())
}

fn table(boards: &[u8], plan: &Plan) -> String {
    let mut text = "t_s".to_owned();
    for board in boards {
        for channel in 0..CHANNELS {
            // Writing to a String does not fail.
            let _ = write!(text, ",b{board}_cmd{channel}_kpa");
        }
    }
    for (t, kpa) in plan.rows() {
        let _ = write!(text, "\n{t:.3}");
        kpa.iter().for_each(|kpa| {
            let _ = write!(text, ",{kpa:.2}");
        });
    }
    text + "\n"
}
