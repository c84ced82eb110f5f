//! Where flash keeps programs, and what boot stage and program tell each other.
//!
//! Frozen: a boot stage is flashed once, and meets programs that are written later.

/// Where flash is mapped.
pub const FLASH: u32 = 0x1000_0000;
/// Two sectors with a record each, `pneudrive_control::update::choice`.
pub const CHOICE: u32 = FLASH + 0x2000;
/// The first of the two places for a program.
pub const FIRST_PLACE: u32 = FLASH + 0x4000;
/// Bytes of a place.
pub const PLACE: u32 = 128 * 1024;
/// Bytes of a sector.
pub const SECTOR: u32 = 4096;
/// Where a program runs, and its vector table is.
pub const RAM: u32 = 0x2000_0000;

/// The watchdog's scratch registers, which only power-off clears. Of the program: what it is
/// ([`State`]), length, CRC. Then how the last trial ended: 0, [`DAMAGED`] or [`NOT_CONFIRMED`].
pub const SCRATCH: [u32; 4] = [0x4005_800c, 0x4005_8010, 0x4005_8014, 0x4005_8018];

/// What the first scratch register says: one of these, plus the place, 0 or 1.
pub struct State;

impl State {
    /// Left by a program: start the one in this place, once.
    pub const TRY: u32 = 0x5452_5900;
    /// Left by the boot stage: this one runs, on trial.
    pub const TRIAL: u32 = 0x5452_4c00;
    /// Left by the boot stage: this one runs, which was confirmed.
    pub const CONFIRMED: u32 = 0x4346_4d00;
    /// Left by the boot stage: the one that was flashed together with it runs.
    pub const FLASHED: u32 = 0x464c_4100;
}

/// The program to be tried was not what its CRC says.
pub const DAMAGED: u32 = 1;
/// A reset came before the program on trial was confirmed.
pub const NOT_CONFIRMED: u32 = 2;
