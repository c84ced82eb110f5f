//! Parts on a native board's I2C connector, a supply sensor and an IMU, and the chip's own
//! temperature sensor.

use super::i2c_world::{I2cConfig, I2cWorld};
use crate::bus::Air;
use pneudrive_control::{ChipThermometer, I2cSensors, Micros, Motion};
use pneudrive_protocol::pages::{Acceleration, AngularRate, GaugePressure, SensorPart, Voltage};

/// The parts, and when they are read.
#[derive(Debug)]
pub(super) struct I2cParts {
    config: I2cConfig,
    world: I2cWorld,
    thermometer: ChipThermometer,
    next_supply_ns: u64,
    next_imu_ns: u64,
    next_temperature_ns: u64,
}

impl I2cParts {
    /// As often as the firmware reads them, ns.
    const SUPPLY_EVERY_NS: u64 = 20_000_000;
    const IMU_EVERY_NS: u64 = 10_000_000;
    const TEMPERATURE_EVERY_NS: u64 = 64_000_000;
    /// What the temperature sensor reads at 27 degrees Celsius, which the emulated chip has, too.
    const TEMPERATURE_CODE: u16 = 876;
    /// What feeds the transducer.
    pub(super) const RAIL_UV: i32 = 5_000_000;

    pub(super) fn new(config: I2cConfig, position: u8) -> Self {
        Self {
            config,
            world: I2cWorld::new(config.seed, position),
            thermometer: ChipThermometer::new(),
            next_supply_ns: 0,
            next_imu_ns: 0,
            next_temperature_ns: 0,
        }
    }

    /// The board has started, and finds them.
    pub(super) fn found_by(&mut self, sensors: &mut I2cSensors) {
        self.thermometer = ChipThermometer::new();
        if self.config.supply {
            sensors.supply_found(SensorPart::Ads1115);
        }
        if self.config.imu {
            sensors.imu_found(SensorPart::Bmi323);
        }
    }

    /// Reads what is due at `now_ns`, which is `clock` for the board.
    pub(super) fn read(&mut self, now_ns: u64, clock: Micros, air: &mut dyn Air, sensors: &mut I2cSensors) {
        if self.config.supply && now_ns >= self.next_supply_ns {
            self.next_supply_ns = now_ns + Self::SUPPLY_EVERY_NS;
            let pa = self.world.supply_pa(now_ns, air);
            // A saturating cast.
            sensors.supply_read(clock, pa.map(|pa| GaugePressure::from_pa(pa.round() as i32)));
            sensors.rail_read(Voltage::from_uv(Self::RAIL_UV));
        }
        if self.config.imu && now_ns >= self.next_imu_ns {
            self.next_imu_ns = now_ns + Self::IMU_EVERY_NS;
            let (acceleration, rate) = self.world.motion(now_ns, air);
            let steps = |values: [f64; 3], per_unit: i16| {
                values.map(|value| (value * f64::from(per_unit)).round() as i16)
            };
            sensors.imu_read(
                clock,
                Motion::new(
                    steps(acceleration, Acceleration::STEPS_PER_M_PER_S2),
                    steps(rate, AngularRate::STEPS_PER_RAD_PER_S),
                ),
            );
        }
        if now_ns >= self.next_temperature_ns {
            self.next_temperature_ns = now_ns + Self::TEMPERATURE_EVERY_NS;
            if let Some(mean) = self.thermometer.reading(Self::TEMPERATURE_CODE) {
                sensors.chip_read(mean);
            }
        }
    }
}
