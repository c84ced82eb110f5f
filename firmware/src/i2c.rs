//! The sensors on the I2C connector: found, read, lost and found again, at the lowest priority.
//!
//! Every 10 ms the IMU is read and every 20 ms the supply pressure; what is not there is looked for
//! once a second. Whatever happens here, the bus and the control loop run above it and do not wait:
//! what was read goes to the board's bus side ([`I2cSensors`](pneudrive_control::I2cSensors)),
//! whose pages say how old it is.
//!
//! A transfer that takes too long, or that something on the bus disturbs, ends the use of the I2C
//! block. Then SCL is clocked by hand until whoever holds SDA lets go, and everything starts again.

mod imu;
mod lines;
mod part;
mod supply;

use crate::shared;
use embassy_executor::task;
use embassy_rp::i2c::{AbortReason, Error};
use embassy_time::{Duration, Ticker, Timer, with_timeout};
use imu::Imu;
pub use lines::Lines;
use lines::Master;
use part::Sensor;
use supply::Supply;

const PERIOD: Duration = Duration::from_millis(10);
/// In periods.
const SEARCH_EVERY: u32 = 100;
/// In periods.
const SUPPLY_EVERY: u32 = 2;
/// The longest thing that is asked of a part, two conversions of the supply, takes 7 ms.
const TIMEOUT: Duration = Duration::from_millis(25);
/// After that, lines that somebody holds for ever are tried again.
const PAUSE: Duration = Duration::from_secs(1);

/// Why something that was asked of a part did not happen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Failure {
    /// It does not acknowledge, or what it sends makes no sense.
    Part,
    /// The bus stands still, or somebody disturbs it.
    Bus,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Abort(AbortReason::ArbitrationLoss) => Self::Bus,
            _ => Self::Part,
        }
    }
}

/// What `of_part` gives, if it ends in time.
async fn in_time<T>(of_part: impl Future<Output = Result<T, Failure>>) -> Result<T, Failure> {
    with_timeout(TIMEOUT, of_part).await.unwrap_or(Err(Failure::Bus))
}

/// Looks after the sensors for ever.
#[task]
pub async fn run(mut lines: Lines) -> ! {
    let (mut supply, mut imu) = (Sensor::<Supply>::ABSENT, Sensor::<Imu>::ABSENT);
    let mut ticker = Ticker::every(PERIOD);
    let mut periods = 0_u32;
    loop {
        let mut master = lines.open();
        loop {
            if round(&mut master, periods, &mut supply, &mut imu).await == Err(Failure::Bus) {
                break;
            }
            ticker.next().await;
            periods = periods.wrapping_add(1);
        }
        if lines.free().await {
            shared::with(|shared| shared.port.sensors().recovered());
        } else {
            supply.lose();
            imu.lose();
            Timer::after(PAUSE).await;
        }
        ticker.reset();
        periods = 0;
    }
}

/// One period. Failures of parts are dealt with; one of the bus ends it.
async fn round(
    master: &mut Master<'_>,
    periods: u32,
    supply: &mut Sensor<Supply>,
    imu: &mut Sensor<Imu>,
) -> Result<(), Failure> {
    if periods.is_multiple_of(SEARCH_EVERY) {
        imu.look(master).await?;
        supply.look(master).await?;
    }
    imu.read(master).await?;
    if periods.is_multiple_of(SUPPLY_EVERY) {
        supply.read(master).await?;
    }
    Ok(())
}
