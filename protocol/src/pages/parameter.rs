/// What a host can change of a board without compiling its firmware; the discriminant is its entry
/// on pages 5 and 6.
///
/// This table is the one that boards, hosts and `docs/firmware.md` use. A number that has been
/// given away keeps its meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Parameter {
    /// Number of the board on the bus, in place of its switch's. [`BY_SWITCH`](Self::BY_SWITCH)
    /// means the switch.
    Address = 0,
    /// Proportional gain.
    Kp = 1,
    /// Damping.
    Kd = 2,
    /// Largest drive.
    Saturation = 3,
    /// Weight of the previous output in the pressure's low-pass.
    FilterPrevious = 4,
    /// Time between two control steps.
    LoopPeriod = 5,
    /// Time from a request to its answer, at the least.
    AnswerDelay = 6,
    /// How long all channels vent after power-up.
    PowerUpVent = 7,
    /// Silence after which the board holds.
    CommandTimeout = 8,
    /// How long it holds before it vents.
    HoldTime = 9,
    /// Reading at the sensors' lowest output.
    SensorMin = 10,
    /// Reading at the sensors' highest output.
    SensorMax = 11,
    /// How far outside these a sample may lie.
    SensorMargin = 12,
    /// Samples in a row outside the limits that make a fault.
    FaultAfterSteps = 13,
    /// Samples in a row inside the limits that end a fault.
    RecoverAfterSteps = 14,
    /// Damaged requests in a window after which the board vents.
    DamageLimit = 15,
    /// That window.
    DamageWindow = 16,
    /// Whether a set point rises only as far as two requests in a row want: 0 or 1.
    RiseNeedsTwo = 17,
    /// Channels in use, bit k for channel k.
    Channels = 18,
    /// Fastest line rate that a host may ask for ([`LineRate`](super::LineRate)).
    MaxBaud = 19,
}

/// Name, unit and range of a [`Parameter`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterInfo {
    /// Its name, as on the command line.
    pub name: &'static str,
    /// Unit of its value; empty for a plain number.
    pub unit: &'static str,
    /// Smallest value, in that unit.
    pub min: u32,
    /// Largest value, in that unit.
    pub max: u32,
    /// What it is, in a few words.
    pub meaning: &'static str,
}

impl Parameter {
    /// How many there are.
    pub const COUNT: usize = 20;

    /// The [`Address`](Self::Address) that means that of the board's switch.
    pub const BY_SWITCH: u32 = 256;

    /// What makes a control loop of 2 kHz of the original's, with the same filter, damping and
    /// sensor faults in time.
    pub const LOOP_2_KHZ: [(Self, u32); 5] = [
        (Self::LoopPeriod, 500),
        (Self::Kd, 40),
        (Self::FilterPrevious, 232),
        (Self::FaultAfterSteps, 20),
        (Self::RecoverAfterSteps, 2_000),
    ];

    /// The same of the original's loop of 1 kHz.
    pub const LOOP_1_KHZ: [(Self, u32); 5] = [
        (Self::LoopPeriod, 1_000),
        (Self::Kd, 20),
        (Self::FilterPrevious, 210),
        (Self::FaultAfterSteps, 10),
        (Self::RecoverAfterSteps, 1_000),
    ];

    /// In the order of their entries.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Address,
        Self::Kp,
        Self::Kd,
        Self::Saturation,
        Self::FilterPrevious,
        Self::LoopPeriod,
        Self::AnswerDelay,
        Self::PowerUpVent,
        Self::CommandTimeout,
        Self::HoldTime,
        Self::SensorMin,
        Self::SensorMax,
        Self::SensorMargin,
        Self::FaultAfterSteps,
        Self::RecoverAfterSteps,
        Self::DamageLimit,
        Self::DamageWindow,
        Self::RiseNeedsTwo,
        Self::Channels,
        Self::MaxBaud,
    ];

    /// Name, unit and range. A value in its range can still be refused together with others (sensor
    /// limits and their margin).
    pub const fn info(self) -> ParameterInfo {
        const fn of(
            name: &'static str,
            unit: &'static str,
            (min, max): (u32, u32),
            meaning: &'static str,
        ) -> ParameterInfo {
            ParameterInfo { name, unit, min, max, meaning }
        }
        match self {
            Self::Address => of("address", "", (0, Self::BY_SWITCH), "number on the bus; 256: by the switch"),
            Self::Kp => of("kp", "drive counts/count", (1, 1_000), "proportional gain"),
            Self::Kd => of("kd", "drive counts/count", (0, 1_000), "damping, per step"),
            Self::Saturation => of("saturation", "drive counts", (1, 400), "largest drive"),
            Self::FilterPrevious => {
                of("filter_previous", "1/256", (0, 255), "weight of the previous sample in the low-pass")
            }
            Self::LoopPeriod => of("loop_period", "us", (100, 10_000), "time between two control steps"),
            Self::AnswerDelay => of("answer_delay", "us", (0, 20), "from request to answer, at the least"),
            Self::PowerUpVent => of("power_up_vent", "ms", (0, 60_000), "vent after power-up"),
            Self::CommandTimeout => of("command_timeout", "ms", (10, 10_000), "silence before it holds"),
            Self::HoldTime => of("hold_time", "ms", (0, 60_000), "hold before it vents"),
            Self::SensorMin => {
                of("sensor_min", "counts", (0, 1_023), "reading at the sensor's lowest output")
            }
            Self::SensorMax => {
                of("sensor_max", "counts", (0, 1_023), "reading at the sensor's highest output")
            }
            Self::SensorMargin => of("sensor_margin", "counts", (0, 1_023), "beyond these it is a fault"),
            Self::FaultAfterSteps => of("fault_after_steps", "steps", (1, 1_000), "bad samples for a fault"),
            Self::RecoverAfterSteps => {
                of("recover_after_steps", "steps", (1, 60_000), "good samples that end it")
            }
            Self::DamageLimit => of("damage_limit", "requests", (1, 10_000), "damaged ones before it vents"),
            Self::DamageWindow => of("damage_window", "ms", (1, 60_000), "in which they are counted"),
            Self::RiseNeedsTwo => of("rise_needs_two", "", (0, 1), "a rise needs two agreeing requests"),
            Self::Channels => of("channels", "", (0, 15), "in use, bit k for channel k"),
            Self::MaxBaud => of("max_baud", "Mbaud", (1, 3), "fastest rate that a host may ask for"),
        }
    }

    /// The parameter in this entry.
    #[inline]
    pub fn of_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// The parameter with this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|parameter| parameter.info().name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::Change;

    #[test]
    fn each_has_its_own_number_and_name_and_a_range_that_a_request_can_carry() {
        for (number, parameter) in (0..).zip(Parameter::ALL) {
            let info = parameter.info();
            assert_eq!((parameter as u8, Parameter::of_number(number)), (number, Some(parameter)));
            assert_eq!(Parameter::of_name(info.name), Some(parameter));
            assert!(info.min < info.max && info.max <= Change::VALUE_MAX, "{info:?}");
        }
        assert_eq!(Parameter::of_number(20), None);
        assert_eq!(Parameter::of_name("gain"), None);
    }
}
