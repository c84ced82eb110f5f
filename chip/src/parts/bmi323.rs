use super::I2cPart;
use crate::ticks::Ticks;

/// Registers (BST-BMI323-DS000 chapter 6), words of 16 bits.
const CHIP_ID: u8 = 0x00;
const STATUS: u8 = 0x02;
const ACC_DATA_X: u8 = 0x03;
const GYR_DATA_Z: u8 = 0x08;
const TEMP_DATA: u8 = 0x09;
const SENSOR_TIME_0: u8 = 0x0a;
const SENSOR_TIME_1: u8 = 0x0b;
const ACC_CONF: u8 = 0x20;
const GYR_CONF: u8 = 0x21;
const CMD: u8 = 0x7e;

const BMI323: u16 = 0x0043;
const POWER_ON_DETECTED: u16 = 1 << 0;
const DATA_READY: u16 = 1 << 6 | 1 << 7;
const SOFT_RESET: u16 = 0xdeaf;
const NO_DATA: u16 = 0x8000;
const TEMPERATURE_23_C: u16 = 0;

const STANDARD_GRAVITY: f64 = 9.806_65;

/// Bosch BMI323: accelerometer and gyroscope.
///
/// Modelled: identification, status, data with the configured ranges, sensor time, soft reset with
/// the 1.5 ms in which it does not answer, and that nothing is measured before a mode is
/// configured. Data are those of an ideal part without a filter; there is no FIFO, no interrupt, no
/// feature engine.
#[derive(Clone, Debug)]
pub struct Bmi323 {
    /// m/s^2.
    acceleration: [f64; 3],
    /// rad/s.
    rate: [f64; 3],
    acc_conf: u16,
    gyr_conf: u16,
    power_on_detected: bool,
    /// It starts up until then.
    ready_at: Ticks,
    register: u8,
    written: Vec<u8>,
    sent: usize,
    word: u16,
}

impl Default for Bmi323 {
    fn default() -> Self {
        Self::new()
    }
}

impl Bmi323 {
    const START_UP: Ticks = Ticks::from_micros(1_500);

    /// As it is after power-on, at rest in free fall.
    pub fn new() -> Bmi323 {
        Bmi323 {
            acceleration: [0.0; 3],
            rate: [0.0; 3],
            acc_conf: 0,
            gyr_conf: 0,
            power_on_detected: true,
            ready_at: Ticks::ZERO,
            register: CHIP_ID,
            written: Vec::new(),
            sent: 0,
            word: 0,
        }
    }

    /// What it measures from now on along and about its axes: acceleration with gravity, m/s^2, and
    /// angular rate, rad/s.
    pub fn set_motion(&mut self, acceleration: [f64; 3], rate: [f64; 3]) {
        (self.acceleration, self.rate) = (acceleration, rate);
    }

    fn measured(conf: u16, value: f64, full_scale: f64) -> u16 {
        // Bits 14 to 12 are the mode: 0 is off, and so is the gyroscope's 1, which keeps its drive
        // on.
        if conf >> 12 & 7 < 2 {
            return NO_DATA;
        }
        // 0x8000 is no measurement.
        let code = (value / full_scale * 32_768.0).round().clamp(-32_767.0, 32_767.0);
        (code as i16).cast_unsigned()
    }

    fn data(&self, register: u8) -> u16 {
        let axis = usize::from(register - ACC_DATA_X);
        let ranges = |conf: u16, smallest: f64| smallest * f64::from(1u32 << (conf >> 4 & 7));
        match axis {
            0..3 => {
                let g = ranges(self.acc_conf, 2.0);
                Bmi323::measured(self.acc_conf, self.acceleration[axis], g * STANDARD_GRAVITY)
            }
            _ => {
                let dps = ranges(self.gyr_conf, 125.0);
                Bmi323::measured(self.gyr_conf, self.rate[axis - 3], dps.to_radians())
            }
        }
    }

    fn read_word(&mut self, now: Ticks, register: u8) -> u16 {
        // Units of 39.0625 us: 25,600 a second.
        let time = (u128::from(now.get()) * 25_600 / u128::from(Ticks::PER_SECOND)) as u32;
        match register {
            CHIP_ID => BMI323,
            STATUS => {
                let power_on =
                    if std::mem::take(&mut self.power_on_detected) { POWER_ON_DETECTED } else { 0 };
                let measures = (self.acc_conf | self.gyr_conf) >> 12 & 7 >= 2;
                power_on | if measures { DATA_READY } else { 0 }
            }
            ACC_DATA_X..=GYR_DATA_Z => self.data(register),
            TEMP_DATA => TEMPERATURE_23_C,
            SENSOR_TIME_0 => time as u16,
            SENSOR_TIME_1 => (time >> 16) as u16,
            ACC_CONF => self.acc_conf,
            GYR_CONF => self.gyr_conf,
            _ => 0,
        }
    }

    fn write_word(&mut self, now: Ticks, register: u8, word: u16) {
        match (register, word) {
            (ACC_CONF, _) => self.acc_conf = word & 0x77ff,
            (GYR_CONF, _) => self.gyr_conf = word & 0x77ff,
            (CMD, SOFT_RESET) => {
                let (acceleration, rate) = (self.acceleration, self.rate);
                *self = Bmi323 { acceleration, rate, ready_at: now + Self::START_UP, ..Bmi323::new() };
            }
            _ => {}
        }
    }
}

impl I2cPart for Bmi323 {
    fn start(&mut self, now: Ticks, _read: bool) -> bool {
        self.written.clear();
        self.sent = 0;
        now >= self.ready_at
    }

    fn write(&mut self, now: Ticks, byte: u8) -> bool {
        self.written.push(byte);
        match self.written[..] {
            [register] => self.register = register & 0x7f,
            [_, low, high] => self.write_word(now, self.register, u16::from_le_bytes([low, high])),
            _ => {}
        }
        true
    }

    /// Two bytes that mean nothing, then words from the register on, low byte first (7.2.4.2).
    fn read(&mut self, now: Ticks) -> u8 {
        let sent = self.sent;
        self.sent += 1;
        let Some(at) = sent.checked_sub(2) else { return 0 };
        if at % 2 == 0 {
            self.word = self.read_word(now, self.register);
            self.register = (self.register + 1) & 0x7f;
            self.word.to_le_bytes()[0]
        } else {
            self.word.to_le_bytes()[1]
        }
    }
}
