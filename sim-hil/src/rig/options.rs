use super::RigError;
use crate::board::{
    ChipBoard, I2cConfig, NativeBoard, NativeBoardConfig, OriginalBoard, PlantAir, Turnaround,
};
use crate::bus::{Bus, BusNode, Line};
use crate::fault::{FaultInjector, FaultSpec};
use crate::plant::{Effect, Plant, PlantParameters};
use crate::record::{ControlSettings, nominal_toml};
use pneudrive_control::BoardConfig;
use pneudrive_protocol::{Address, Baud};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

/// How long bytes take on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Timing {
    /// As long as the line rate says.
    #[default]
    Wire,
    /// No time to speak of, and no turnaround: the host's own speed is what is left.
    Instant,
}

/// The firmware's ELF file, to run on emulated chips.
#[derive(Clone, PartialEq, Eq)]
pub struct Firmware(Arc<[u8]>);

impl Firmware {
    /// The file's contents; whether they are a program is seen when a board is built with them.
    pub fn new(elf: impl Into<Arc<[u8]>>) -> Self {
        Self(elf.into())
    }
}

impl fmt::Debug for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Firmware({} bytes)", self.0.len())
    }
}

/// A rig to build. The default is one healthy board at 1 Mbaud with the nominal plant.
#[derive(Debug, Clone, PartialEq)]
pub struct RigOptions {
    /// Boards on the bus, 1 to 256, with addresses from 0.
    pub boards: usize,
    /// Line rate of [`Timing::Wire`].
    pub baud: Baud,
    /// How long bytes take.
    pub timing: Timing,
    /// When answers begin, with [`Timing::Wire`].
    pub turnaround: Turnaround,
    /// The boards' control loops. `baud` is set to the line's, `hears_itself` to false;
    /// `answer_delay` is `turnaround`'s business here.
    pub control: BoardConfig,
    /// Run this on emulated chips instead of native boards: one to four boards, [`Timing::Wire`] at
    /// the firmware's 1 Mbaud; `turnaround` and `control` are then the firmware's business.
    pub firmware: Option<Firmware>,
    /// Positions of boards that behave as the original's firmware does, with its faults
    /// ([`OriginalBoard`]): whatever `control`, `turnaround` and `firmware` say. None by default.
    pub original: BTreeSet<u8>,
    /// Positions of boards with a sensor of the supply pressure on their I2C connector. None by
    /// default.
    pub supply_sensors: BTreeSet<u8>,
    /// Positions of boards with an IMU on their I2C connector. None by default.
    pub imus: BTreeSet<u8>,
    /// The plant; `channels` is set to four a board.
    pub plant: PlantParameters,
    /// Effects switched on in the plant.
    pub effects: Vec<Effect>,
    /// Faults to inject.
    pub faults: Vec<FaultSpec>,
    /// Of plant and faults. Equal options give equal runs, bit for bit.
    pub seed: u64,
    /// Every violation on the bus is a panic. For tests on a bus without faults.
    pub strict: bool,
}

/// Two loops of a board, ns.
const FIRST_LOOPS_NS: u64 = 2_000_000;

impl Default for RigOptions {
    fn default() -> Self {
        Self {
            boards: 1,
            baud: Baud::ORIGINAL,
            timing: Timing::Wire,
            turnaround: Turnaround::FIRMWARE,
            control: BoardConfig::default(),
            firmware: None,
            original: BTreeSet::new(),
            supply_sensors: BTreeSet::new(),
            imus: BTreeSet::new(),
            plant: PlantParameters::default(),
            effects: Vec::new(),
            faults: Vec::new(),
            seed: 0,
            strict: false,
        }
    }
}

impl RigOptions {
    /// The same rig, with supply sensor and IMU on every board that can have them.
    #[must_use]
    pub fn with_all_sensors(self) -> Self {
        let ours = |n: &u8| !self.original.contains(n);
        let boards: BTreeSet<u8> = (0..=u8::MAX).take(self.boards).filter(ours).collect();
        Self { supply_sensors: boards.clone(), imus: boards, ..self }
    }

    /// As many as there are addresses.
    pub const BOARDS_MAX: usize = 256;

    /// The line that the boards share.
    ///
    /// # Errors
    /// No resistor gives the 555's pulse at this line rate.
    pub fn line(&self) -> Result<Line, RigError> {
        Ok(match self.timing {
            Timing::Wire => Line::at_baud(self.baud)?,
            Timing::Instant => Line::instant(),
        })
    }

    /// When boards that were powered up at time 0 have vented and follow their commands, ns.
    #[must_use]
    pub fn follow_after_ns(&self) -> u64 {
        let ours_ns = self.control.power_up_vent.get() * 1_000;
        let vented_ns =
            if self.original.is_empty() { ours_ns } else { ours_ns.max(OriginalBoard::POWER_UP_VENT_NS) };
        // Boards are not in step with each other.
        vented_ns + FIRST_LOOPS_NS
    }

    /// Builds the rig, at time 0.
    ///
    /// # Errors
    /// What the options ask for is impossible; the error names it.
    pub fn build(&self) -> Result<Bus, RigError> {
        let boards = u8::try_from(self.boards.wrapping_sub(1));
        let last = boards.map_err(|_| RigError::Boards { boards: self.boards })?;
        let line = self.line()?;
        if let Some(&position) = self.original.last().filter(|&&position| position > last) {
            return Err(RigError::Original { position, boards: self.boards });
        }
        for (what, positions) in [("a supply sensor", &self.supply_sensors), ("an IMU", &self.imus)] {
            let foreign = |&position: &u8| position > last || self.original.contains(&position);
            if let Some(position) = positions.iter().copied().find(|position| foreign(position)) {
                return Err(RigError::Part { what, position, boards: self.boards });
            }
        }
        let node = |n| match &self.firmware {
            _ if self.original.contains(&n) => Ok(original_board(n, line)),
            None => self.native_board(n, line),
            Some(firmware) => self.chip_board(firmware, n, line),
        };
        let nodes = (0..=last).map(node).collect::<Result<Vec<_>, RigError>>()?;
        let faults = FaultInjector::new(&self.faults, line, self.boards, self.seed)?;
        Ok(Bus::new(line, nodes, Box::new(self.air()?), faults, self.strict))
    }

    /// The air behind the boards.
    ///
    /// # Errors
    /// A plant parameter or effect outside its range.
    pub fn air(&self) -> Result<PlantAir, RigError> {
        let parameters = PlantParameters { channels: 4 * self.boards, ..self.plant.clone() };
        let step_ns = parameters.step_ns;
        Ok(PlantAir::new(Plant::new(parameters, &self.effects, self.seed)?, step_ns))
    }

    /// The rig file of a recording that a host makes of these boards: what its user would know of
    /// the rig, and the law that these boards run. Effects and nuisances are left out.
    ///
    /// # Errors
    /// [`RigError::FirmwareLaw`]: the law of a firmware file is not known.
    pub fn rig_toml(&self) -> Result<String, RigError> {
        if self.firmware.is_some() {
            return Err(RigError::FirmwareLaw);
        }
        Ok(nominal_toml(&self.plant, &ControlSettings::from(&self.control))?)
    }

    fn i2c(&self, n: u8) -> I2cConfig {
        I2cConfig { supply: self.supply_sensors.contains(&n), imu: self.imus.contains(&n), seed: self.seed }
    }

    fn chip_board(
        &self,
        Firmware(elf): &Firmware,
        n: u8,
        line: Line,
    ) -> Result<Box<dyn BusNode + Send>, RigError> {
        if self.timing != Timing::Wire || self.baud != Baud::ORIGINAL {
            return Err(RigError::FirmwareTiming);
        }
        if self.boards > ChipBoard::POSITIONS {
            return Err(RigError::FirmwareBoards { boards: self.boards });
        }
        Ok(Box::new(ChipBoard::from_elf(elf, n, line, self.i2c(n))?))
    }

    fn native_board(&self, n: u8, line: Line) -> Result<Box<dyn BusNode + Send>, RigError> {
        // A line that takes no time asks of the boards what their fastest line rate does: shortest
        // gaps and echoes.
        let (baud, turnaround) = match self.timing {
            Timing::Wire => (self.baud, self.turnaround),
            Timing::Instant => (fastest_baud(), Turnaround::Fixed { delay_ns: 0 }),
        };
        // On this bus no board hears itself, so none has to close its ears while it answers.
        let control = BoardConfig { baud, hears_itself: false, ..self.control };
        // Crystals start when they start: the boards' loops are spread over the period.
        let period_ns = control.loop_period.get() * 1_000;
        let phase_ns = u64::from(n) * period_ns * 3 / 11 % period_ns;
        let i2c = self.i2c(n);
        let config = NativeBoardConfig { control, turnaround, phase_ns, i2c, ..NativeBoardConfig::default() };
        Ok(Box::new(NativeBoard::new(config, Address::of_board(n), n, line)?))
    }
}

fn original_board(n: u8, line: Line) -> Box<dyn BusNode + Send> {
    // The boards' loops are spread over the period, as those of native boards.
    let phase_ns = u64::from(n) * OriginalBoard::LOOP_NS * 3 / 11 % OriginalBoard::LOOP_NS;
    Box::new(OriginalBoard::new(Address::of_board(n), n, line, phase_ns))
}

fn fastest_baud() -> Baud {
    Baud::new(Baud::MAX).unwrap_or(Baud::ORIGINAL)
}
