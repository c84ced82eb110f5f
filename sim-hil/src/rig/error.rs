use crate::fault::FaultError;
use crate::plant::PlantError;
use pneudrive_control::ConfigError;
use pneudrive_protocol::pulse::PulseError;
use thiserror::Error;

/// A rig that cannot be built.
#[derive(Debug, Error)]
pub enum RigError {
    /// No board, or more than there are addresses.
    #[error("{boards} boards: a bus has 1 to {max}", max = super::RigOptions::BOARDS_MAX)]
    Boards {
        /// The number that was refused.
        boards: usize,
    },
    /// A board of the original kind where there is no board.
    #[error(
        "no board at position {position}, which is to be of the original kind: there are {boards} boards"
    )]
    Original {
        /// The position that was asked for.
        position: u8,
        /// Boards of the rig.
        boards: usize,
    },
    /// A part on the I2C connector of a board that has none.
    #[error(
        "no board at position {position} that can have {what}: there are {boards} boards, and those of the original kind have none"
    )]
    Part {
        /// The part.
        what: &'static str,
        /// The position that was asked for.
        position: u8,
        /// Boards of the rig.
        boards: usize,
    },
    /// The firmware's line rate is its own.
    #[error("firmware runs its bus at 1,000,000 baud in wire time: no other baud rate and no instant timing")]
    FirmwareTiming,
    /// The address switch has two contacts.
    #[error("{boards} boards with firmware: the address switch has {max} positions", max = crate::board::ChipBoard::POSITIONS)]
    FirmwareBoards {
        /// The number that was refused.
        boards: usize,
    },
    /// Gains are in the firmware's code.
    #[error(
        "the control law of a firmware file is not known here: take the rig file of native boards, and put the firmware's gains in"
    )]
    FirmwareLaw,
    /// The rig file cannot be written as TOML.
    #[error("rig file: {0}")]
    RigFile(#[from] toml::ser::Error),
    /// The file is no firmware.
    #[error("firmware: {0}")]
    Firmware(#[from] pneudrive_chip::ElfError),
    /// No resistor gives the 555's pulse at this line rate.
    #[error(transparent)]
    Pulse(#[from] PulseError),
    /// A control parameter outside its limits.
    #[error("board configuration: {0}")]
    Board(#[from] ConfigError),
    /// A plant parameter or effect outside its range.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// A fault that this rig cannot have.
    #[error(transparent)]
    Fault(#[from] FaultError),
}
