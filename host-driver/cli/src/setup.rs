//! `--rig`: what the rig file says, beneath what the command line says.

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::output::errln;
use pneudrive_host::Calibration;
use pneudrive_host::rig::{self, Rig, Unit};

/// The rig as the program uses it. Without a rig file all is nominal and nothing has a name.
#[derive(Debug, Clone, Default)]
pub struct Setup {
    /// The file.
    pub rig: Option<Rig>,
    /// What counts mean.
    pub calibration: Calibration,
    /// What people see.
    pub unit: Unit,
}

impl Setup {
    /// Reads the file that the command line names, and puts its port, boards, line rate and rate
    /// where the command line has none.
    pub fn load(cli: &mut Cli) -> Result<Self, Failure> {
        let Some(path) = &cli.bus.rig else {
            return Ok(Self { unit: cli.bus.unit.unwrap_or_default(), ..Self::default() });
        };
        let rig = Rig::load(path).map_err(|error| {
            let hint = if path.exists() { "" } else { "; `pneudrive-host init` writes one" };
            Failure::input(format!("{error}{hint}"))
        })?;
        let calibration = rig::calibration(&rig).map_err(Failure::input)?;
        let bus = rig.bus();
        let polls = cli.command.as_ref().is_none_or(Command::polls);
        let args = &mut cli.bus;
        if polls || (args.devices.is_none() && bus.boards.is_some()) {
            let said = args.devices.map(|devices| (devices, format!("--devices {devices}")));
            let given = said.as_ref().map(|(devices, said)| (*devices, said.as_str()));
            if let Some(left_out) = rig::left_out(&rig, given).map_err(Failure::input)? {
                errln!("warning: {left_out}");
            }
        }
        args.port = args.port.take().or(bus.port.map(Into::into));
        args.baud = args.baud.or(rig::baud(&rig));
        if args.devices.is_none() {
            rig::few_enough(&rig, args.max_devices, "--max-devices").map_err(Failure::input)?;
            args.devices = bus.boards;
        }
        // Only polling has a rate, and its options are refused by the rest.
        match &mut cli.command {
            None => cli.run.rate = cli.run.rate.or(bus.rate_hz),
            Some(Command::Replay(replay)) => replay.run.rate = replay.run.rate.or(bus.rate_hz),
            Some(_) => {}
        }
        let unit = args.unit.unwrap_or_else(|| rig.unit());
        Ok(Self { rig: Some(rig), calibration, unit })
    }

    /// Pressure of the atmosphere, kPa absolute, where the rig file says it.
    pub fn ambient_kpa(&self) -> Option<f64> {
        self.rig.as_ref().and_then(Rig::ambient_kpa)
    }

    /// `board 2`, or `board 2 (elbow)`.
    pub fn board(&self, board: u8) -> String {
        match self.rig.as_ref().and_then(|rig| rig.board_name(board)) {
            Some(name) => format!("board {board} ({name})"),
            None => format!("board {board}"),
        }
    }

    /// What people call a channel.
    pub fn channel(&self, board: u8, channel: usize) -> Option<&str> {
        self.rig.as_ref()?.channel_name(board, channel)
    }
}
