//! ADS1115 with a pressure transducer at AIN0 and the transducer's supply at AIN1: the supply pressure.

use super::{Failure, Found, Master, in_time};
use crate::{config, shared};
use embedded_ads111x::{ADS111x, ADS111xConfig, DataRate, InputMultiplexer, Mode, ProgramableGainAmplifier};
use pneudrive_control::Transducer;
use pneudrive_protocol::pages::{GaugePressure, SensorPart, Voltage};

/// ADDR at ground.
const ADDRESS: u8 = 0x48;
const CONFIG: u8 = 0x01;
/// Starts no conversion. A thermometer with this address (TMP102) reads two bits of it, its R1 and R0, as 1.
const IDLE: [u8; 2] = [0x41, 0xe3];

const TRANSDUCER: Transducer = Transducer { full_scale_pa: config::SUPPLY_FULL_SCALE_PA };

/// The converter, if there is one.
pub(super) enum Supply {
    Absent,
    Found(Found),
}

impl Supply {
    /// Looks for one, if there is none yet.
    pub(super) async fn look(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        if let Self::Found(_) = self {
            return Ok(());
        }
        match in_time(is_there(master)).await {
            Ok(true) => {
                *self = Self::Found(Found::at(ADDRESS));
                shared::with(|shared| shared.port.sensors().supply_found(SensorPart::Ads1115));
                Ok(())
            }
            Err(Failure::Bus) => Err(Failure::Bus),
            Ok(false) | Err(Failure::Part) => Ok(()),
        }
    }

    /// Reads it, if there is one.
    pub(super) async fn read(&mut self, master: &mut Master<'_>) -> Result<(), Failure> {
        let Self::Found(found) = self else { return Ok(()) };
        match in_time(measure(master, found.address)).await {
            Ok((pressure, rail)) => {
                found.failures = 0;
                let now = shared::now();
                shared::with(|shared| {
                    shared.port.sensors().supply_read(now, pressure);
                    shared.port.sensors().rail_read(rail);
                });
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
        shared::with(|shared| shared.port.sensors().supply_lost());
    }
}

/// An ADS1115 has no register that says what it is: its configuration can be written and read back.
async fn is_there(master: &mut Master<'_>) -> Result<bool, Failure> {
    let [high, low] = IDLE;
    master.write_async(ADDRESS, [CONFIG, high, low]).await?;
    let mut read = [0; 2];
    master.write_read_async(ADDRESS, [CONFIG], &mut read).await?;
    // Its highest bit says that it does not convert.
    Ok([read[0] & 0x7f, read[1]] == IDLE)
}

/// The pressure by the output's share of the transducer's supply, `None` if that is none that it gives; and that supply.
///
/// Each conversion is asked for with the whole configuration, so that one that has lost its power meanwhile measures the same.
async fn measure(master: &mut Master<'_>, address: u8) -> Result<(Option<GaugePressure>, Voltage), Failure> {
    let config = ADS111xConfig::default()
        .pga(ProgramableGainAmplifier::V6_144)
        .mode(Mode::Signle)
        .dr(DataRate::SPS860);
    let Ok(mut converter) = ADS111x::new(master, address, config) else { return Err(Failure::Part) };
    let output = converter.read_single_voltage(Some(InputMultiplexer::AIN0GND)).await?;
    let supply = converter.read_single_voltage(Some(InputMultiplexer::AIN1GND)).await?;
    let supply = microvolts(supply);
    Ok((TRANSDUCER.pressure(microvolts(output), supply), Voltage::from_uv(supply)))
}

/// The driver gives volts as the only floating-point numbers of this program.
#[expect(clippy::float_arithmetic)]
fn microvolts(volts: f32) -> i32 {
    (volts * 1e6) as i32
}
