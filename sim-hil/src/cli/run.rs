use super::Failure;
use crate::board::Turnaround;
use crate::fault::FaultSpec;
use crate::plant::{Effect, Nuisances, PlantParameters};
use crate::pty::{FrontEnd, PtyOptions, SimError, SimReport};
use crate::rig::{Firmware, RigOptions, Timing};
use clap::{Args, ValueEnum};
use pneudrive_protocol::Baud;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Run boards behind a pseudo-terminal.
#[derive(Debug, Args)]
pub(super) struct RunArgs {
    /// Boards on the bus, 1 to 256, with addresses from 0
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = parse_devices)]
    devices: usize,
    /// Make a symbolic link to the port here; removed at the end
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// How long bytes take on the wire
    #[arg(long, value_enum, default_value = "wire")]
    timing: TimingArg,
    /// Line rate of the virtual wire, bit/s, 1200 to 7812500 (what a client sets on the port is
    /// ignored)
    #[arg(long, value_name = "RATE", default_value_t = Baud::ORIGINAL.get(), value_parser = parse_baud)]
    baud: u32,
    /// From a request's last stop bit to the answer's first start bit, us, 0 to 1000000
    #[arg(long, value_name = "US", default_value_t = 15.0, value_parser = parse_turnaround)]
    turnaround_us: f64,
    /// Answer once a loop of 0.86 ms, as the published PneuDrive's boards do, instead of after a
    /// fixed turnaround
    #[arg(long, conflicts_with = "turnaround_us")]
    original_loop: bool,
    /// These boards behave as the published PneuDrive firmware does, faults included: numbers
    /// separated by commas, or all
    #[arg(long, value_name = "BOARDS", value_parser = parse_boards)]
    original: Option<BoardsArg>,
    /// These boards measure the supply pressure: numbers separated by commas, or all
    #[arg(long, value_name = "BOARDS", value_parser = parse_boards)]
    supply_sensor: Option<BoardsArg>,
    /// These boards have an IMU, on the end plate of their joint: numbers separated by commas, or
    /// all
    #[arg(long, value_name = "BOARDS", value_parser = parse_boards)]
    imu: Option<BoardsArg>,
    /// Run this firmware on emulated chips instead of native boards: 1 to 4 devices, wire timing at
    /// 1 Mbaud
    #[arg(long, value_name = "ELF", conflicts_with_all = ["turnaround_us", "original_loop"])]
    firmware: Option<PathBuf>,
    /// Switch an effect on in the plant, as in supply_sag=40 or valve_hysteresis=0.06@b0c2;
    /// repeatable
    #[arg(long = "effect", value_name = "EFFECT")]
    effects: Vec<Effect>,
    /// Inject a fault on the bus, as in bit_flip=1e-4,on=answers or unplug@3,board=1; repeatable
    #[arg(long = "fault", value_name = "FAULT")]
    faults: Vec<FaultSpec>,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Free the joints
    #[arg(long)]
    joints: bool,
    /// Laboratory nuisances: 1 % supply wander, 5 % spread between channels
    #[arg(long)]
    nuisances: bool,
    /// Write the rig file for recordings of these boards here
    #[arg(long, value_name = "TOML", conflicts_with = "firmware")]
    rig_out: Option<PathBuf>,
    /// End after this much time, s, above 0
    #[arg(long, value_name = "S", value_parser = parse_duration)]
    duration: Option<Duration>,
    /// Date requests back by this instead of the measured round trip of the pty, us
    #[arg(long, value_name = "US")]
    pty_latency_us: Option<u64>,
    /// Put each request on the wire when it is seen, as a plain responder would, instead of dating
    /// it back by the pty's round trip
    #[arg(long, conflicts_with = "pty_latency_us")]
    no_dating: bool,
    /// Wait the last so many us before an answer is due, and the first after it, in a loop instead
    /// of asleep
    #[arg(long, value_name = "US", default_value_t = 20, value_parser = clap::value_parser!(u64).range(0..=1_000))]
    spin_us: u64,
    /// Hand over at most so many bytes together; 1 hands over each at its own stop bit
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=4_096))]
    fifo: u16,
}

/// Some of the boards.
#[derive(Debug, Clone)]
enum BoardsArg {
    All,
    These(BTreeSet<u8>),
}

impl BoardsArg {
    /// Their numbers; none where nothing was said.
    fn of(boards: Option<&Self>, devices: usize) -> BTreeSet<u8> {
        match boards {
            None => BTreeSet::new(),
            Some(Self::All) => (0..=u8::MAX).take(devices).collect(),
            Some(Self::These(boards)) => boards.clone(),
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum TimingArg {
    /// As long as the line rate says
    Wire,
    /// No time: answers come at once
    Instant,
}

impl RunArgs {
    fn rig(&self) -> Result<RigOptions, Failure> {
        let mut plant = PlantParameters::default();
        plant.joint.free = self.joints;
        if self.nuisances {
            plant.nuisances = Nuisances::laboratory();
        }
        let turnaround = if self.original_loop {
            Turnaround::ORIGINAL
        } else {
            Turnaround::Fixed { delay_ns: (self.turnaround_us * 1e3).round() as u64 }
        };
        Ok(RigOptions {
            boards: self.devices,
            baud: Baud::new(self.baud).map_err(|error| Failure { status: 2, message: error.to_string() })?,
            timing: match self.timing {
                TimingArg::Wire => Timing::Wire,
                TimingArg::Instant => Timing::Instant,
            },
            turnaround,
            firmware: self.firmware()?,
            original: BoardsArg::of(self.original.as_ref(), self.devices),
            supply_sensors: BoardsArg::of(self.supply_sensor.as_ref(), self.devices),
            imus: BoardsArg::of(self.imu.as_ref(), self.devices),
            plant,
            effects: self.effects.clone(),
            faults: self.faults.clone(),
            seed: self.seed,
            ..RigOptions::default()
        })
    }

    fn firmware(&self) -> Result<Option<Firmware>, Failure> {
        let Some(path) = &self.firmware else { return Ok(None) };
        let message = |error| format!("cannot read the firmware {}: {error}", path.display());
        let elf = std::fs::read(path).map_err(|error| Failure { status: 2, message: message(error) })?;
        Ok(Some(Firmware::new(elf)))
    }

    fn write_rig(&self, rig: &RigOptions) -> Result<(), Failure> {
        let Some(path) = &self.rig_out else { return Ok(()) };
        let text = rig.rig_toml().map_err(|error| Failure { status: 2, message: error.to_string() })?;
        let message = |error| format!("cannot write the rig file {}: {error}", path.display());
        std::fs::write(path, text).map_err(|error| Failure { status: 2, message: message(error) })
    }

    pub fn execute(&self) -> Result<(), Failure> {
        let stop = super::stop_on_signal()?;
        let pty = PtyOptions {
            link: self.link.clone(),
            pty_latency: self.pty_latency_us.map(Duration::from_micros),
            dates_back: !self.no_dating,
            spin: Duration::from_micros(self.spin_us),
            fifo: usize::from(self.fifo),
            past_power_up: false,
        };
        let rig = self.rig()?;
        self.write_rig(&rig)?;
        let mut front_end = FrontEnd::new(&rig, &pty).map_err(Failure::from)?;
        say(&front_end.path().display().to_string());
        let result = front_end.run(&stop, self.duration);
        say(&json(&front_end.report()));
        result.map_err(Failure::from)
    }
}

/// Whoever started it may have stopped listening; that ends nothing.
fn say(line: &str) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

fn json(report: &SimReport) -> String {
    // Numbers and names only: nothing that JSON could not hold.
    serde_json::to_string(report).unwrap_or_default()
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        let status = match error {
            SimError::Rig(_) | SimError::Link { .. } => 2,
            SimError::Pty { .. } | SimError::Thread { .. } => 1,
        };
        Self { status, message: error.to_string() }
    }
}

fn parse_devices(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "expected a whole number from 1 to 256".to_owned())
}

fn parse_baud(text: &str) -> Result<u32, String> {
    let value: u32 = text.parse().map_err(|_| format!("'{text}' is no whole number of bit/s"))?;
    Baud::new(value).map(Baud::get).map_err(|error| error.to_string())
}

fn parse_boards(text: &str) -> Result<BoardsArg, String> {
    if text == "all" {
        return Ok(BoardsArg::All);
    }
    let number = |word: &str| word.trim().parse::<u8>();
    let boards: Result<BTreeSet<u8>, _> = text.split(',').map(number).collect();
    boards
        .map(BoardsArg::These)
        .map_err(|_| format!("'{text}' is neither 'all' nor board numbers from 0 to 255 as in 0,2"))
}

fn parse_turnaround(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|us| (0.0..=1e6).contains(us));
    value.ok_or_else(|| format!("'{text}' is no number of us from 0 to 1000000"))
}

fn parse_duration(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| format!("'{text}' is no number of seconds above 0"))
}
