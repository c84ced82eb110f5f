//! What this board is configured to.

use pneudrive_control::BoardConfig;

/// The original's control law, limits and times. Change them here.
pub const BOARD: BoardConfig = BoardConfig::ORIGINAL;

const _: () =
    assert!(BOARD.check().is_ok(), "a parameter is outside its limits (pneudrive-control, BoardConfig)");

/// Readings of each sensor that are averaged into one sample. Sixteen rounds of four channels at 2
/// us a reading take 128 us.
pub const OVERSAMPLING: usize = 16;

/// Control steps between two readings of the chip's temperature, of which sixteen make a mean: one
/// a second.
pub const TEMPERATURE_EVERY_STEPS: u32 = 64;

/// Full scale of the supply pressure's transducer on the I2C connector, Pa above the atmosphere: 10
/// bar.
pub const SUPPLY_FULL_SCALE_PA: i32 = 1_000_000;

/// PWM frequency, Hz: that of the original (16 MHz / 510, an Arduino's phase-correct timer).
pub const PWM_HZ: u32 = 31_372;

/// All DIR and PWM pins, bit n for GPIO n; `pins.rs` says which is which.
pub const VALVE_PINS: u32 = 0b0011_1111_1100_0000;
