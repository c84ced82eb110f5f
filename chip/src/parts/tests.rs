use super::{Ads1115, Bmi323, I2cPart};
use crate::ticks::Ticks;

fn write(part: &mut impl I2cPart, now: Ticks, bytes: &[u8]) -> bool {
    let acknowledged = part.start(now, false) && bytes.iter().all(|byte| part.write(now, *byte));
    part.stop(now);
    acknowledged
}

/// Writes the register's address and reads after a repeated START.
fn read<const N: usize>(part: &mut impl I2cPart, now: Ticks, register: u8) -> [u8; N] {
    assert!(part.start(now, false) && part.write(now, register) && part.start(now, true));
    let bytes = std::array::from_fn(|_| part.read(now));
    part.stop(now);
    bytes
}

mod ads1115 {
    use super::*;

    fn word(part: &mut Ads1115, now: Ticks, register: u8) -> u16 {
        u16::from_be_bytes(read(part, now, register))
    }

    #[test]
    fn registers_are_as_after_power_on() {
        let mut part = Ads1115::new();
        let words = [0, 1, 2, 3].map(|register| word(&mut part, Ticks::ZERO, register));
        assert_eq!(words, [0, 0x8583, 0x8000, 0x7fff]);
    }

    /// AIN0 to ground, 6.144 V, single-shot, 860 samples a second.
    #[test]
    fn a_single_conversion_takes_its_time() {
        let mut part = Ads1115::new();
        part.set_input_uv(0, 3_000_000);
        assert!(write(&mut part, Ticks::ZERO, &[1, 0xc1, 0xe3]));
        assert_eq!(word(&mut part, Ticks::from_micros(1_162), 1), 0x41e3, "OS is 0: it converts");
        assert_eq!(word(&mut part, Ticks::from_micros(1_162), 0), 0);
        assert_eq!(word(&mut part, Ticks::from_micros(1_163), 1), 0xc1e3);
        assert_eq!(word(&mut part, Ticks::from_micros(1_163), 0), 16_000, "187.5 uV a step");
        part.set_input_uv(0, 0);
        assert_eq!(word(&mut part, Ticks::from_millis(100), 0), 16_000, "only when asked");
    }

    #[test]
    fn continuous_conversions_follow_the_input() {
        let mut part = Ads1115::new();
        assert!(write(&mut part, Ticks::ZERO, &[1, 0x72, 0x83]), "AIN3 to ground, 4.096 V");
        part.set_input_uv(3, 1_000_000);
        assert_eq!(word(&mut part, Ticks::from_millis(8), 0), 8_000);
        part.set_input_uv(3, -4_000_000);
        assert_eq!(word(&mut part, Ticks::from_millis(15), 0), 8_000, "the conversion has not ended");
        assert_eq!(word(&mut part, Ticks::from_millis(16), 0).cast_signed(), -32_000);
        assert_eq!(part.conversions(), 2);
    }

    #[test]
    fn differences_and_limits() {
        let mut part = Ads1115::new();
        part.set_input_uv(0, 100_000);
        part.set_input_uv(1, 400_000);
        assert!(write(&mut part, Ticks::ZERO, &[1, 0x84, 0xe3]), "AIN0 - AIN1, 2.048 V");
        assert_eq!(word(&mut part, Ticks::from_millis(2), 0).cast_signed(), -4_800);
        assert!(write(&mut part, Ticks::from_millis(2), &[1, 0xdb, 0xe3]), "AIN1, 0.256 V");
        assert_eq!(word(&mut part, Ticks::from_millis(4), 0), 0x7fff);
    }
}

mod bmi323 {
    use super::*;

    /// Words behind the two bytes that mean nothing.
    fn words<const N: usize>(part: &mut Bmi323, register: u8) -> [u16; N] {
        let now = Ticks::from_millis(10);
        assert!(part.start(now, false) && part.write(now, register) && part.start(now, true));
        let mut word = || u16::from_le_bytes([part.read(now), part.read(now)]);
        word();
        std::array::from_fn(|_| word())
    }

    #[test]
    fn nothing_is_measured_before_a_mode_is_set() {
        let mut part = Bmi323::new();
        part.set_motion([0.0, 0.0, 9.80665], [1.0; 3]);
        assert_eq!(words(&mut part, 0), [0x43]);
        assert_eq!(words(&mut part, 3), [0x8000; 6]);
        assert_eq!(words(&mut part, 2), [1], "power-on detected, once");
        assert_eq!(words(&mut part, 2), [0]);
    }

    #[test]
    fn data_have_the_configured_range() {
        let mut part = Bmi323::new();
        part.set_motion([0.0, -9.80665, 9.80665], [0.0, 250f64.to_radians(), -500f64.to_radians()]);
        assert!(write(&mut part, Ticks::from_millis(10), &[0x20, 0x18, 0x40]), "normal mode, 4 g");
        assert!(write(&mut part, Ticks::from_millis(10), &[0x21, 0x28, 0x40]), "normal mode, 500 deg/s");
        let data: [u16; 6] = words(&mut part, 3);
        assert_eq!(data.map(u16::cast_signed), [0, -8_192, 8_192, 0, 16_384, -32_767]);
        assert_eq!(words(&mut part, 0x20), [0x4018, 0x4028]);
    }

    #[test]
    fn a_reset_forgets_the_configuration_and_takes_its_time() {
        let mut part = Bmi323::new();
        let at = Ticks::from_millis(5);
        assert!(write(&mut part, at, &[0x20, 0x18, 0x40]));
        assert!(write(&mut part, at, &[0x7e, 0xaf, 0xde]));
        assert!(!part.start(at + Ticks::from_micros(1_499), true), "it starts up");
        assert!(part.start(at + Ticks::from_micros(1_500), true));
        assert_eq!(words(&mut part, 0x20), [0]);
    }

    /// 3,276.8 units of 39.0625 us are 128 ms.
    #[test]
    fn sensor_time_counts_units_of_39_us() {
        let mut part = Bmi323::new();
        let bytes: [u8; 6] = read(&mut part, Ticks::from_millis(128_000), 0x0a);
        let time = u32::from_le_bytes([bytes[2], bytes[3], bytes[4], bytes[5]]);
        assert_eq!(time, 3_276_800);
    }
}
