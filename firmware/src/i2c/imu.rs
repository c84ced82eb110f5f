//! BMI323: acceleration and angular rate.

use super::{Failure, Found, Master, in_time};
use crate::shared;
use bmi323_driver::{
    AccelConfig, AccelMode, AccelRange, AverageSamples, AxisData, Bandwidth, Bmi323, Error, GyroConfig,
    GyroMode, GyroRange, OutputDataRate,
};
use embassy_rp::i2c;
use embassy_time::Delay;
use pneudrive_control::{Motion, acceleration_steps, angular_rate_steps};
use pneudrive_protocol::pages::SensorPart;

/// By the level at its SDO pin.
const ADDRESSES: [u8; 2] = [0x68, 0x69];
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

/// The IMU, if there is one.
pub(super) enum Imu {
    Absent,
    Found(Found),
}

impl Imu {
    /// Looks for one and sets it up, if there is none yet.
    pub(super) async fn look(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        if let Self::Found(_) = self {
            return Ok(());
        }
        for address in ADDRESSES {
            match in_time(set_up(master, address)).await {
                Ok(()) => {
                    *self = Self::Found(Found::at(address));
                    shared::with(|shared| shared.port.sensors().imu_found(SensorPart::Bmi323));
                    return Ok(());
                }
                Err(Failure::Part) => {}
                Err(Failure::Bus) => return Err(Failure::Bus),
            }
        }
        Ok(())
    }

    /// Reads it, if there is one.
    pub(super) async fn read(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        let Self::Found(found) = self else { return Ok(()) };
        match in_time(measure(master, found.address)).await {
            Ok(motion) => {
                found.failures = 0;
                let now = shared::now();
                shared::with(|shared| shared.port.sensors().imu_read(now, motion));
                Ok(())
            }
            Err(failure) => {
                if found.fails() {
                    self.lose();
                }
                if failure == Failure::Bus { Err(failure) } else { Ok(()) }
            }
        }
    }

    /// It is not there any more.
    pub(super) fn lose(&mut self) {
        *self = Self::Absent;
        shared::with(|shared| shared.port.sensors().imu_lost());
    }
}

/// Other parts have these addresses, too: nothing is written before it says what it is.
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
