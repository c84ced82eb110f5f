use pneudrive_protocol::pages::Temperature;

/// The mean of the chip's own temperature sensor, from 12-bit codes of its ADC.
///
/// Both chips have the same sensor: 0.706 V at 27 degrees Celsius, 1.721 mV less for each degree
/// more (RP2040 datasheet 4.9.5, RP2350 datasheet 12.4.6), measured against 3.3 V. Sensors differ,
/// and 1 % of the 3.3 V is 4 degrees.
///
/// ```
/// use pneudrive_control::ChipThermometer;
///
/// let mut thermometer = ChipThermometer::new();
/// let means: Vec<_> = (0..32).filter_map(|_| thermometer.reading(876)).collect();
/// assert_eq!(means.len(), 2);
/// assert_eq!(means[0].celsius(), 27.2);
/// ```
#[derive(Debug, Clone, Default)]
pub struct ChipThermometer {
    sum: u16,
    readings: u16,
}

impl ChipThermometer {
    /// Readings in a mean: 4095 times as many fit into 16 bits.
    pub const READINGS: u16 = 16;
    const CODE_MAX: u16 = 4_095;

    /// Without a reading.
    pub const fn new() -> Self {
        Self { sum: 0, readings: 0 }
    }

    /// Takes a reading. Every [`READINGS`](Self::READINGS)th completes a mean.
    pub fn reading(&mut self, code: u16) -> Option<Temperature> {
        self.sum += code.min(Self::CODE_MAX);
        self.readings += 1;
        if self.readings < Self::READINGS {
            return None;
        }
        Some(temperature(core::mem::take(self).sum))
    }
}

/// Steps are 5 (27 + 50 + (0.706 - sum 3.3 / 65,536) / 0.001721), a sum being that of 16 codes;
/// here times 2^17.
const fn temperature(sum: u16) -> Temperature {
    const SHIFT: u32 = 17;
    const AT_ZERO: i32 = 319_308_833;
    const PER_SUM: i32 = 19_175;
    // At most 1.26e9.
    let steps = AT_ZERO - sum as i32 * PER_SUM;
    Temperature::from_steps((steps + (1 << (SHIFT - 1))) >> SHIFT)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To half a step, 0.1 degrees, and what the whole-numbered factor has too much: 0.05 steps at
    /// the largest sum.
    #[test]
    fn the_datasheets_line_holds_over_the_whole_range() {
        for sum in 0..=16 * ChipThermometer::CODE_MAX {
            let volts = f64::from(sum) / 16.0 * 3.3 / 4_096.0;
            let celsius: f64 = 27.0 - (volts - 0.706) / 0.001_721;
            let expected = celsius.clamp(-50.0, 154.4);
            let got = temperature(sum).celsius();
            assert!((got - expected).abs() < 0.11, "{sum}: {got} instead of {expected}");
        }
    }

    #[test]
    fn a_mean_lies_between_two_codes_and_the_next_begins_anew() {
        let mut thermometer = ChipThermometer::new();
        let mut mean = |codes: [u16; 2]| {
            let all: [_; 16] = core::array::from_fn(|n| thermometer.reading(codes[n % 2]));
            assert!(all[..15].iter().all(Option::is_none));
            all[15].unwrap().celsius()
        };
        assert_eq!(mean([876, 876]), 27.2);
        assert_eq!(mean([876, 878]), 26.6);
        assert_eq!(mean([u16::MAX, u16::MAX]), -50.0);
        assert_eq!(mean([876, 876]), 27.2);
    }
}
