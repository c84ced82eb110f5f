//! `pneudrive-ros`: PneuDrive boards as a ROS 2 node. Needs no ROS installation, neither to build
//! nor to run.
//!
//! ```text
//!  serial port ── bus thread ──ring──▶ publisher thread ──DDS──▶ ~/joint_N/pressure_state
//!  (one each)         ▲                                                       /diagnostics
//!                     └──atomics── gate ◀── node thread ◀──DDS── ~/joint_N/pressure_command
//! ```
//!
//! The bus threads never wait for DDS: states are left in a ring that may overflow (that is
//! counted), set points are atomics.

mod args;
mod bus;
mod channel_names;
mod descriptions;
mod diagnostic_msgs;
mod diagnostics;
mod failure;
mod flags;
mod fluid_pressure;
mod gate;
mod live;
mod logger;
mod names;
mod node;
mod parameter_services;
mod parameters;
mod params_file;
mod pressure;
mod publish;
mod refusal;
mod ros_args;
mod rosout;
mod run;
mod sensors;
mod services;
mod tap;
mod unix_time;

use args::Settings;
use std::process::ExitCode;

/// Exit status: 0 done, 1 failed while running, 2 unusable arguments.
fn main() -> ExitCode {
    logger::install();
    let settings = match Settings::from_command_line(std::env::args_os()) {
        Ok(settings) => settings,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    match run::run(&settings) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            error.status()
        }
    }
}
