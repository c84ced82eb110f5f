//! The pressure sensor and its converter: gauge pressure to volts to counts.
//!
//! Ratiometric, 0.5 to 4.5 V over 0 to 100 psi with a 5 V supply that is also the converter's
//! reference, so counts depend on the pressure alone. Converters round to the nearest code
//! (transitions half a step either side).

use rand_chacha::ChaCha8Rng;

use super::noise::{Purpose, normal, stream, uniform};
use super::physics::SensorPhysics;

/// Full scale of the sensor, 100 psi in kPa.
pub const FULL_SCALE_KPA: f64 = 689.475_7;
/// Supply of the sensor and reference of the converter, V.
pub const ADC_REFERENCE_V: f64 = 5.0;
const ZERO_V: f64 = 0.5;
const SPAN_V: f64 = 4.0;

/// Sensor voltage at a gauge pressure in kPa.
#[must_use]
pub fn kpa_to_volts(kpa: f64) -> f64 {
    ZERO_V + SPAN_V * kpa / FULL_SCALE_KPA
}

/// Gauge pressure in kPa at a sensor voltage.
#[must_use]
pub fn volts_to_kpa(volts: f64) -> f64 {
    (volts - ZERO_V) / SPAN_V * FULL_SCALE_KPA
}

/// Gauge pressure in kPa of 12-bit counts (as counts/4096 of the reference).
#[must_use]
pub fn counts12_to_kpa(counts: f64) -> f64 {
    volts_to_kpa(counts / 4096.0 * ADC_REFERENCE_V)
}

/// Gauge pressure in kPa of the bus's 10-bit counts (as counts/1024 of the reference).
#[must_use]
pub fn counts10_to_kpa(counts: f64) -> f64 {
    volts_to_kpa(counts / 1024.0 * ADC_REFERENCE_V)
}

/// 10-bit counts, unrounded, at a gauge pressure in kPa.
#[must_use]
pub fn kpa_to_counts10(kpa: f64) -> f64 {
    kpa_to_volts(kpa) / ADC_REFERENCE_V * 1024.0
}

/// One channel's sensor.
#[derive(Debug, Clone)]
pub struct Sensor {
    physics: SensorPhysics,
    /// Share of the way to the pressure the output makes in one integration step.
    lag_share: Option<f64>,
    filtered_pa: f64,
    /// What a diaphragm with friction shows, kPa.
    shown_kpa: f64,
    noise: ChaCha8Rng,
    stale: ChaCha8Rng,
    stale_until_s: f64,
    last_sample_s: Option<f64>,
    volts: f64,
    counts12: u16,
}

impl Sensor {
    pub fn new(physics: &SensorPhysics, step_s: f64, gauge_pa: f64, seed: u64, place: usize) -> Self {
        let lag_share = (physics.lag_s > 0.0).then(|| -(-step_s / physics.lag_s).exp_m1());
        let volts = kpa_to_volts(1e-3 * gauge_pa);
        Self {
            physics: physics.clone(),
            lag_share,
            filtered_pa: gauge_pa,
            shown_kpa: 1e-3 * gauge_pa,
            noise: stream(seed, Purpose::SensorNoise, place),
            stale: stream(seed, Purpose::Stale, place),
            stale_until_s: 0.0,
            last_sample_s: None,
            volts,
            counts12: convert(volts, physics.bits),
        }
    }

    /// Whether [`Sensor::follow`] has anything to do.
    #[inline]
    pub fn lags(&self) -> bool {
        self.lag_share.is_some()
    }

    /// Follows the port's gauge pressure over one integration step, from `before` to `after`.
    #[inline]
    pub fn follow(&mut self, before_pa: f64, after_pa: f64) {
        if let Some(share) = self.lag_share {
            self.filtered_pa += share * (0.5 * (before_pa + after_pa) - self.filtered_pa);
        }
    }

    /// Voltage the sensor puts out for `gauge_pa` at its port, with noise, before the converter's
    /// multiplexer.
    fn output_volts(&mut self, gauge_pa: f64, time_s: f64) -> f64 {
        let p = &self.physics;
        let kpa = 1e-3 * if self.lag_share.is_some() { self.filtered_pa } else { gauge_pa };
        // From one sample to the next the pressure goes one way: it is pushed along by whichever
        // end of the gap touches.
        self.shown_kpa = self.shown_kpa.clamp(kpa - p.play_kpa, kpa + p.play_kpa);
        let kpa = self.shown_kpa;
        let share = kpa / FULL_SCALE_KPA;
        let mut reading = p.gain * kpa + p.offset_kpa + 4.0 * p.bow_kpa * share * (1.0 - share);
        if let Some((final_kpa, time_constant)) = p.drift {
            reading += final_kpa * -(-time_s / time_constant).exp_m1();
        }
        reading += p.noise_kpa * normal(&mut self.noise);
        kpa_to_volts(reading).clamp(0.0, ADC_REFERENCE_V)
    }

    /// Converts one sample. `held_v` is the charge the channel sampled before left on the
    /// converter's capacitor; what this one leaves is returned.
    pub fn sample(&mut self, gauge_pa: f64, time_s: f64, held_v: f64) -> f64 {
        let output = self.output_volts(gauge_pa, time_s);
        let settled = output + self.physics.crosstalk * (held_v - output);
        if !self.is_stale(time_s) {
            self.volts = settled;
            self.counts12 = convert(settled, self.physics.bits);
        }
        settled
    }

    /// Stale spells start at random such that they fill their share of the time, and have an
    /// exponential length.
    fn is_stale(&mut self, time_s: f64) -> bool {
        let Some((share, spell_s)) = self.physics.stale else {
            return false;
        };
        let since = self.last_sample_s.replace(time_s).map_or(0.0, |last| time_s - last);
        if time_s < self.stale_until_s {
            return true;
        }
        let mean_fresh = spell_s * (1.0 - share) / share;
        if uniform(&mut self.stale) < -(-since / mean_fresh).exp_m1() {
            self.stale_until_s = time_s + spell_s * super::noise::exponential(&mut self.stale);
            return time_s < self.stale_until_s;
        }
        false
    }

    /// Voltage of the last sample at the converter, V.
    pub fn volts(&self) -> f64 {
        self.volts
    }

    /// 12-bit counts of the last sample.
    pub fn counts12(&self) -> u16 {
        self.counts12
    }
}

/// Nearest code of a `bits`-bit converter, on the 12-bit scale.
pub fn convert(volts: f64, bits: u32) -> u16 {
    let codes = f64::from(1_u32 << bits);
    let code = (volts / ADC_REFERENCE_V * codes).round().clamp(0.0, codes - 1.0);
    let on_12_bits = (code * 4096.0 / codes).floor();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=4095 above")]
    let counts = on_12_bits as u16;
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The original's scale: zero at 102.4 counts of 10 bits, 0.841645 kPa a count.
    #[test]
    fn scale_is_the_originals() {
        assert!((kpa_to_counts10(0.0) - 102.4).abs() < 1e-12);
        assert!((counts10_to_kpa(103.4) - 0.841_645).abs() < 1e-6);
        assert!((counts12_to_kpa(4.0 * 200.0) - counts10_to_kpa(200.0)).abs() < 1e-9);
        assert!((kpa_to_volts(689.475_7) - 4.5).abs() < 1e-12);
    }

    #[test]
    fn converter_rounds_and_clips() {
        assert_eq!(convert(0.5, 12), 410); // 409.6
        assert_eq!(convert(0.5, 10), 408); // 102.4 -> 102, on the 12-bit scale
        assert_eq!(convert(5.0, 12), 4095);
        assert_eq!(convert(0.0, 12), 0);
    }
}
