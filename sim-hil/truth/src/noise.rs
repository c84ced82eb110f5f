//! Seeded randomness. Every use has its own stream, so that switching one thing on does not change
//! another's numbers.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Exp1, StandardNormal};

/// What a stream of random numbers is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// What differs between channels of one make.
    Spread = 1,
    /// Noise of a channel's pressure sensor.
    SensorNoise = 2,
    /// When a sensor shows an old sample again.
    Stale = 3,
    /// Wander of the supply pressure.
    SupplyWander = 4,
    /// Phase of the supply's ripple.
    RipplePhase = 5,
    /// Water that comes through the valves.
    Water = 6,
    /// Noise of the supply's sensor.
    SupplySensor = 7,
    /// Commands and drives of a recording.
    Excitation = 8,
    /// Curves of a [`Background`](crate::Background).
    Background = 9,
    /// Wander of the supply pressure within seconds, of a [`Background`](crate::Background).
    FastWander = 10,
    /// Noise of an inertial sensor.
    Imu = 11,
}

/// The stream of one purpose in one place (a channel's index, or 0 for the rig).
pub fn stream(seed: u64, purpose: Purpose, place: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((purpose as u64) << 32) | place as u64);
    rng
}

/// A standard normal deviate.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

/// An exponential deviate of mean 1.
pub fn exponential(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(Exp1)
}

/// A uniform deviate, 0 to 1.
pub fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    rng.random()
}

/// Ornstein-Uhlenbeck process of unit variance, exact at knots and straight in between.
#[derive(Debug, Clone)]
pub struct Wander {
    rng: ChaCha8Rng,
    decay: f64,
    kick: f64,
    knot_s: f64,
    next_knot: f64,
    from: f64,
    to: f64,
}

impl Wander {
    /// Correlation time `time_s`; the knots lie a two-hundredth of it apart, at most 0.1 s.
    pub fn new(mut rng: ChaCha8Rng, time_s: f64) -> Self {
        let knot_s = (time_s / 200.0).min(0.1);
        let decay = (-knot_s / time_s).exp();
        let from = normal(&mut rng);
        let mut wander =
            Self { rng, decay, kick: (1.0 - decay * decay).sqrt(), knot_s, next_knot: 0.0, from, to: from };
        wander.next();
        wander
    }

    fn next(&mut self) {
        self.from = self.to;
        self.to = self.decay * self.from + self.kick * normal(&mut self.rng);
        self.next_knot += self.knot_s;
    }

    /// Value at `time_s`, which must not run backwards.
    pub fn at(&mut self, time_s: f64) -> f64 {
        while time_s > self.next_knot {
            self.next();
        }
        let share = 1.0 - (self.next_knot - time_s) / self.knot_s;
        self.from + share * (self.to - self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_purpose_place_and_seed_and_repeat() {
        let draw = |seed, purpose, place| normal(&mut stream(seed, purpose, place)).to_bits();
        assert_eq!(draw(1, Purpose::Water, 3), draw(1, Purpose::Water, 3));
        assert_ne!(draw(1, Purpose::Water, 3), draw(2, Purpose::Water, 3));
        assert_ne!(draw(1, Purpose::Water, 3), draw(1, Purpose::Stale, 3));
        assert_ne!(draw(1, Purpose::Water, 3), draw(1, Purpose::Water, 4));
    }

    /// Variance 1 and correlation exp(-1) one correlation time apart, over 20 000 correlation times
    /// (standard error 0.01).
    #[test]
    fn wander_has_its_variance_and_correlation_time() {
        let mut wander = Wander::new(stream(5, Purpose::SupplyWander, 0), 2.0);
        let x: Vec<f64> = (0..20_000).map(|k| wander.at(2.0 * f64::from(k))).collect();
        let n = x.len() as f64;
        let variance = x.iter().map(|v| v * v).sum::<f64>() / n;
        let lagged = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1.0);
        assert!((variance - 1.0).abs() < 0.05, "{variance}");
        assert!((lagged - (-1.0_f64).exp()).abs() < 0.05, "{lagged}");
    }
}
