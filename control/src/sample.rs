use core::num::NonZeroU16;
use pneudrive_protocol::{CHANNELS, Counts};

/// Bits behind the binary point of a pressure inside the board: 1/256 count, or 3 Pa with the
/// original's sensor.
///
/// Sixteen averaged 12-bit readings resolve 1/64 count; the two bits beyond that keep the averaging
/// exact for counts of readings that are no power of two.
pub const FRACTION_BITS: u32 = 8;

/// A pressure in counts of the bus with [`FRACTION_BITS`] fraction bits, 0 to 1023.75.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct FineCounts(i32);

impl FineCounts {
    pub(crate) const fn from_counts(counts: Counts) -> Self {
        Self((counts.get() as i32) << FRACTION_BITS)
    }

    pub(crate) const fn from_raw(raw: i32) -> Self {
        Self(raw)
    }

    pub(crate) const fn raw(self) -> i32 {
        self.0
    }

    /// The nearest count, of two equally near ones the even one: a fourth of all 12-bit codes lie
    /// half-way, and rounding them up would report an eighth of a count (0.1 kPa) too much in the
    /// mean. Above 1023.5, which only the ADC's last two codes are, it is 1023.
    pub(crate) fn rounded(self) -> Counts {
        const HALF: i32 = 1 << (FRACTION_BITS - 1);
        let odd = self.0 >> FRACTION_BITS & 1;
        let nearest = (self.0 + HALF - 1 + odd) >> FRACTION_BITS;
        Counts::saturating(nearest.clamp(0, i32::from(Counts::MAX.get())) as u16)
    }
}

/// What one channel's ADC input read in one loop period: the average of one or more 12-bit
/// readings, in counts of the bus.
///
/// Four 12-bit codes are one count. The average is rounded to 1/256 count, not cut off to whole
/// counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AdcSample(FineCounts);

impl AdcSample {
    /// Largest 12-bit code; larger readings count as this one.
    pub const READING_MAX: u16 = 4095;
    /// Most readings that are averaged into one sample; the sum of more might not fit.
    pub const READINGS_MAX: u16 = 4096;
    /// 12-bit codes in one count of the bus, as a shift.
    const CODES_PER_COUNT_BITS: u32 = 2;

    /// From one 12-bit reading.
    pub const fn from_reading(code: u16) -> Self {
        Self::average(code as u32, NonZeroU16::MIN)
    }

    /// From the sum of `readings` 12-bit readings.
    ///
    /// Returns `None` if there are more than [`READINGS_MAX`](Self::READINGS_MAX) readings, or if
    /// the sum is more than so many 12-bit readings can add up to.
    pub const fn from_sum(sum: u32, readings: NonZeroU16) -> Option<Self> {
        let largest = Self::READING_MAX as u32 * readings.get() as u32;
        if readings.get() > Self::READINGS_MAX || sum > largest {
            return None;
        }
        Some(Self::average(sum, readings))
    }

    /// From `ROUNDS` rounds of an ADC that samples channels 0 to 3 in turn.
    ///
    /// `ROUNDS` outside 1 to [`READINGS_MAX`](Self::READINGS_MAX) does not compile.
    pub fn from_rounds<const ROUNDS: usize>(rounds: &[[u16; CHANNELS]; ROUNDS]) -> [Self; CHANNELS] {
        let readings = const {
            assert!(ROUNDS >= 1 && ROUNDS <= Self::READINGS_MAX as usize);
            NonZeroU16::new(ROUNDS as u16).unwrap()
        };
        let mut sums = [0_u32; CHANNELS];
        for round in rounds {
            for (sum, code) in sums.iter_mut().zip(round) {
                *sum += u32::from((*code).min(Self::READING_MAX));
            }
        }
        sums.map(|sum| Self::average(sum, readings))
    }

    pub(crate) const fn fine(self) -> FineCounts {
        self.0
    }

    /// 4095 * 4096 << 6 is below 2^30: nothing overflows.
    #[inline]
    const fn average(sum: u32, readings: NonZeroU16) -> Self {
        let readings = readings.get() as u32;
        let largest = Self::READING_MAX as u32 * readings;
        let sum = if sum <= largest { sum } else { largest };
        let scaled = sum << (FRACTION_BITS - Self::CODES_PER_COUNT_BITS);
        Self(FineCounts::from_raw(((scaled + readings / 2) / readings) as i32))
    }
}

impl From<Counts> for AdcSample {
    fn from(counts: Counts) -> Self {
        Self(FineCounts::from_counts(counts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearest(sample: AdcSample) -> u16 {
        sample.fine().rounded().get()
    }

    #[test]
    fn four_codes_are_one_count_and_halves_round_to_even() {
        let codes = [0, 1, 2, 5, 6, 409, 410, 4093, 4094, 4095, u16::MAX];
        let counts = codes.map(|code| nearest(AdcSample::from_reading(code)));
        assert_eq!(counts, [0, 0, 0, 1, 2, 102, 102, 1023, 1023, 1023, 1023]);
        // Over any eight codes in a row the mean is that of the codes.
        let sum: u16 = (400..408).map(|code| nearest(AdcSample::from_reading(code))).sum();
        assert_eq!(4 * sum, (400..408).sum());
    }

    #[test]
    fn averaging_keeps_what_lies_between_two_codes() {
        // 410 and 411 alternating are 410.5 codes, 102.625 counts.
        let rounds = [[410; 4], [411; 4]];
        assert_eq!(AdcSample::from_rounds(&rounds)[3].fine().raw(), 26_272);
        // 101 codes over 3 readings are 8.4167 counts: 2154.67 parts of 256.
        let three = NonZeroU16::new(3).unwrap();
        assert_eq!(AdcSample::from_sum(101, three).unwrap().fine().raw(), 2_155);
    }

    #[test]
    fn rounds_are_sorted_by_channel() {
        let samples = AdcSample::from_rounds(&[[4, 8, 12, 16]; 16]);
        assert_eq!(samples.map(nearest), [1, 2, 3, 4]);
    }

    #[test]
    fn the_largest_sums_fit_and_larger_ones_are_refused() {
        let most = NonZeroU16::new(4096).unwrap();
        assert_eq!(AdcSample::from_sum(4095 * 4096, most), Some(AdcSample::from_reading(4095)));
        assert_eq!(AdcSample::from_sum(4095 * 4096 + 1, most), None);
        assert_eq!(AdcSample::from_sum(0, NonZeroU16::new(4097).unwrap()), None);
    }
}
