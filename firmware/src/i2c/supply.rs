//! ADS1115 with a pressure transducer at AIN0 and the transducer's supply at AIN1: the supply
//! pressure.

use super::part::Part;
use super::{Failure, Master};
use crate::config;
use embedded_ads111x::{ADS111x, ADS111xConfig, DataRate, InputMultiplexer, Mode, ProgramableGainAmplifier};
use pneudrive_control::{I2cSensors, Micros, Transducer};
use pneudrive_protocol::pages::{GaugePressure, SensorPart, Voltage};

const CONFIG: u8 = 0x01;
/// Starts no conversion. A thermometer with this address (TMP102) reads two bits of it, its R1 and
/// R0, as 1.
const IDLE: [u8; 2] = [0x41, 0xe3];

const TRANSDUCER: Transducer = Transducer { full_scale_pa: config::SUPPLY_FULL_SCALE_PA };

/// The converter.
pub(super) struct Supply;

impl Part for Supply {
    /// The pressure by the output's share of the transducer's supply, `None` if that is none that
    /// it gives; and that supply.
    type Reading = (Option<GaugePressure>, Voltage);
    /// ADDR at ground.
    const ADDRESSES: &[u8] = &[0x48];

    /// An ADS1115 has no register that says what it is: its configuration can be written and read
    /// back.
    async fn set_up(master: &mut Master<'_>, address: u8) -> Result<(), Failure> {
        let [high, low] = IDLE;
        master.write_async(address, [CONFIG, high, low]).await?;
        let mut read = [0; 2];
        master.write_read_async(address, [CONFIG], &mut read).await?;
        // Its highest bit says that it does not convert.
        if [read[0] & 0x7f, read[1]] == IDLE { Ok(()) } else { Err(Failure::Part) }
    }

    /// Each conversion is asked for with the whole configuration, so that one that has lost its
    /// power meanwhile measures the same.
    async fn measure(master: &mut Master<'_>, address: u8) -> Result<Self::Reading, Failure> {
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

    fn found(sensors: &mut I2cSensors) {
        sensors.supply_found(SensorPart::Ads1115);
    }

    fn read(sensors: &mut I2cSensors, now: Micros, (pressure, rail): Self::Reading) {
        sensors.supply_read(now, pressure);
        sensors.rail_read(rail);
    }

    fn lost(sensors: &mut I2cSensors) {
        sensors.supply_lost();
    }
}

/// The driver gives volts as the only floating-point numbers of this program.
#[expect(clippy::float_arithmetic)]
fn microvolts(volts: f32) -> i32 {
    (volts * 1e6) as i32
}
