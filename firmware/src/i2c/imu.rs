//! BMI323: acceleration and angular rate.

use super::part::Part;
use super::{Failure, Master};
use bmi323_driver::{
    AccelConfig, AccelMode, AccelRange, AverageSamples, AxisData, Bandwidth, Bmi323, Error, GyroConfig,
    GyroMode, GyroRange, OutputDataRate,
};
use embassy_rp::i2c;
use embassy_time::Delay;
use pneudrive_control::{I2cSensors, Micros, Motion, acceleration_steps, angular_rate_steps};
use pneudrive_protocol::pages::SensorPart;

const CHIP_ID: u8 = 0x00;
const BMI323: u8 = 0x43;
/// What a data register holds before there are data, and after a reset.
const NO_DATA: i16 = i16::MIN;

const ACCELERATION: AccelConfig = AccelConfig {
    mode: AccelMode::Normal,
    average: AverageSamples::Avg1,
    bandwidth: Bandwidth::OdrOver2,
    range: AccelRange::G4,
    odr: OutputDataRate::Hz100,
};
const RATE: GyroConfig = GyroConfig {
    mode: GyroMode::Normal,
    average: AverageSamples::Avg1,
    bandwidth: Bandwidth::OdrOver2,
    range: GyroRange::Dps500,
    odr: OutputDataRate::Hz100,
};

impl From<Error<i2c::Error>> for Failure {
    fn from(error: Error<i2c::Error>) -> Self {
        match error {
            Error::Bus(error) => error.into(),
            _ => Self::Part,
        }
    }
}

/// The IMU.
pub(super) struct Imu;

impl Part for Imu {
    type Reading = Motion;
    /// By the level at its SDO pin.
    const ADDRESSES: &[u8] = &[0x68, 0x69];

    /// Nothing is written before it says what it is.
    async fn set_up(master: &mut Master<'_>, address: u8) -> Result<(), Failure> {
        let mut id = [0; 4];
        master.write_read_async(address, [CHIP_ID], &mut id).await?;
        // Two bytes that mean nothing come first.
        if id[2] != BMI323 {
            return Err(Failure::Part);
        }
        let mut imu = Bmi323::new_i2c(master, address);
        imu.init(&mut Delay).await?;
        imu.set_accel_config(ACCELERATION).await?;
        Ok(imu.set_gyro_config(RATE).await?)
    }

    /// One that has lost its power meanwhile has no data.
    async fn measure(master: &mut Master<'_>, address: u8) -> Result<Motion, Failure> {
        let data = Bmi323::new_i2c(master, address).read_imu_data().await?;
        let axes = |axes: AxisData| [axes.x, axes.y, axes.z];
        let (acceleration, rate) = (axes(data.accel), axes(data.gyro));
        if acceleration.contains(&NO_DATA) || rate.contains(&NO_DATA) {
            return Err(Failure::Part);
        }
        Ok(Motion::new(acceleration.map(acceleration_steps), rate.map(angular_rate_steps)))
    }

    fn found(sensors: &mut I2cSensors) {
        sensors.imu_found(SensorPart::Bmi323);
    }

    fn read(sensors: &mut I2cSensors, now: Micros, motion: Motion) {
        sensors.imu_read(now, motion);
    }

    fn lost(sensors: &mut I2cSensors) {
        sensors.imu_lost();
    }
}
