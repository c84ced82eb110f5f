//! Emulated parts on the I2C connector of an emulated chip.

use super::i2c_parts::I2cParts;
use super::i2c_world::{I2cConfig, I2cWorld};
use super::pin_map::{I2C_BLOCK, I2C_SCL, I2C_SDA, IMU_ADDRESS, SUPPLY_ADDRESS};
use crate::bus::Air;
use pneudrive_chip::Chip;
use pneudrive_chip::parts::{Ads1115, Bmi323};

/// What is on the connector, and has what before it.
#[derive(Debug)]
pub(super) struct ChipParts {
    config: I2cConfig,
    world: I2cWorld,
}

impl ChipParts {
    /// Full scale of the transducer, Pa: that which the firmware is compiled with.
    const FULL_SCALE_PA: f64 = 1_000_000.0;
    /// A ratiometric transducer's output at 0, and what full scale adds, as shares of its supply.
    const ZERO: f64 = 0.1;
    const SPAN: f64 = 0.8;

    pub(super) fn new(config: I2cConfig, position: u8) -> Self {
        Self { config, world: I2cWorld::new(config.seed, position) }
    }

    /// Wires the connector.
    pub(super) fn wire(chip: &mut Chip) {
        chip.wire_i2c(I2C_SDA, I2C_SCL);
    }

    /// The parts get their power, with the board.
    pub(super) fn power_on(&self, chip: &mut Chip) {
        if self.config.supply {
            chip.attach_i2c(I2C_BLOCK, SUPPLY_ADDRESS, Ads1115::new());
        }
        if self.config.imu {
            chip.attach_i2c(I2C_BLOCK, IMU_ADDRESS, Bmi323::new());
        }
    }

    /// Puts before the parts what they measure from now on.
    pub(super) fn renew(&mut self, chip: &mut Chip, now_ns: u64, air: &mut dyn Air) {
        if let Some(part) = chip.i2c_part::<Ads1115>(I2C_BLOCK, SUPPLY_ADDRESS) {
            let share = |pa| Self::ZERO + Self::SPAN * pa / Self::FULL_SCALE_PA;
            // Without a supply nothing is connected. The cast saturates.
            let output = self.world.supply_pa(now_ns, air).map_or(0.0, share);
            part.set_input_uv(0, (output * f64::from(I2cParts::RAIL_UV)).round() as i32);
            part.set_input_uv(1, I2cParts::RAIL_UV);
        }
        if let Some(part) = chip.i2c_part::<Bmi323>(I2C_BLOCK, IMU_ADDRESS) {
            let (acceleration, rate) = self.world.motion(now_ns, air);
            part.set_motion(acceleration, rate);
        }
    }
}
