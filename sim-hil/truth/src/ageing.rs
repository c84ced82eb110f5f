//! What changes slowly in a channel: a wearing valve, a coil that heats up, water in the line, a
//! crack that grows.

use rand_chacha::ChaCha8Rng;

use super::noise::exponential;
use super::physics::{AgeingPhysics, WaterPhysics};

/// Factors for one integration step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Multiplies the valve's slope.
    pub gain: f64,
    /// Multiplies every conductance between valve and chamber.
    pub passage: f64,
    /// Conductance of a crack in the chamber's wall, m^3/(s Pa).
    pub crack: f64,
}

impl Condition {
    /// A channel in which nothing changes.
    pub const NEW: Self = Self { gain: 1.0, passage: 1.0, crack: 0.0 };
}

/// One channel's slow states.
#[derive(Debug, Clone)]
pub struct Ageing {
    physics: AgeingPhysics,
    step_s: f64,
    /// Heating of the coil relative to the steady state at full duty, 0 to 1.
    warmth: f64,
    crack: f64,
    water: Option<Water>,
}

impl Ageing {
    /// `None` when nothing ages, so that the integrator can skip it. `rng` is drawn from only by
    /// water.
    pub fn new(physics: &AgeingPhysics, step_s: f64, rng: ChaCha8Rng) -> Option<Self> {
        let AgeingPhysics { wear_per_s, heating, water, burst } = physics;
        let still = wear_per_s.abs() <= 0.0 && heating.is_none() && water.is_none() && burst.is_none();
        (!still).then(|| Self {
            physics: physics.clone(),
            step_s,
            warmth: 0.0,
            crack: 0.0,
            water: water.map(|w| Water::new(w, rng)),
        })
    }

    /// The condition for the step that starts at `time_s`, with the coil at duty `coil` and the
    /// chamber at `gauge_pa`.
    pub fn step(&mut self, time_s: f64, coil: f64, gauge_pa: f64) -> Condition {
        let mut condition = Condition { gain: (self.physics.wear_per_s * time_s).exp(), ..Condition::NEW };
        if let Some((loss, time_constant)) = self.physics.heating {
            // Joule heat goes with the square of the current.
            self.warmth += (coil * coil - self.warmth) * self.step_s / time_constant;
            condition.gain *= 1.0 - loss * self.warmth;
        }
        if let Some(water) = &mut self.water {
            condition.passage = water.step(time_s, self.step_s);
        }
        if let Some(burst) = self.physics.burst {
            self.crack += burst.growth * (gauge_pa - burst.threshold_pa).max(0.0) * self.step_s;
            condition.crack = self.crack;
        }
        condition
    }
}

/// Slugs arrive at random, stay for a random time and blur at their ends.
#[derive(Debug, Clone)]
struct Water {
    physics: WaterPhysics,
    rng: ChaCha8Rng,
    present: bool,
    next_change_s: f64,
    blocked: f64,
}

/// Time a slug takes to enter or leave the restriction, s.
const SLUG_EDGE_S: f64 = 0.03;

impl Water {
    fn new(physics: WaterPhysics, mut rng: ChaCha8Rng) -> Self {
        let next_change_s = physics.mean_gap_s * exponential(&mut rng);
        Self { physics, rng, present: false, next_change_s, blocked: 0.0 }
    }

    fn step(&mut self, time_s: f64, step_s: f64) -> f64 {
        while time_s >= self.next_change_s {
            self.present = !self.present;
            let mean = if self.present { self.physics.mean_slug_s } else { self.physics.mean_gap_s };
            self.next_change_s += mean * exponential(&mut self.rng);
        }
        let wanted = if self.present { self.physics.depth } else { 0.0 };
        self.blocked += (wanted - self.blocked) * step_s / SLUG_EDGE_S;
        1.0 - self.blocked
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::{Purpose, stream};
    use super::super::physics::BurstPhysics;
    use super::*;

    const H: f64 = 1e-4;

    fn ageing(physics: AgeingPhysics) -> Ageing {
        Ageing::new(&physics, H, stream(1, Purpose::Water, 0)).unwrap()
    }

    fn after(a: &mut Ageing, steps: u32, coil: f64, gauge: f64) -> Condition {
        let mut last = Condition::NEW;
        for k in 0..steps {
            last = a.step(f64::from(k) * H, coil, gauge);
        }
        last
    }

    #[test]
    fn nothing_to_age_is_skipped() {
        assert!(Ageing::new(&AgeingPhysics::default(), H, stream(1, Purpose::Water, 0)).is_none());
    }

    #[test]
    fn wear_is_exponential_in_time() {
        let mut a = ageing(AgeingPhysics { wear_per_s: -0.1, ..AgeingPhysics::default() });
        assert!((a.step(10.0, 0.0, 0.0).gain - (-1.0_f64).exp()).abs() < 1e-12);
    }

    /// First-order heating with the square of the duty: after one time constant at half duty, 0.25
    /// (1 - 1/e).
    #[test]
    fn coil_heats_with_the_square_of_the_duty() {
        let mut a = ageing(AgeingPhysics { heating: Some((0.4, 0.5)), ..AgeingPhysics::default() });
        let gain = after(&mut a, 5000, 0.5, 0.0).gain;
        assert!((gain - (1.0 - 0.4 * 0.25 * (1.0 - (-1.0_f64).exp()))).abs() < 1e-4, "{gain}");
    }

    #[test]
    fn crack_grows_only_above_its_threshold() {
        let burst = BurstPhysics { growth: 1e-15, threshold_pa: 2e5 };
        let mut a = ageing(AgeingPhysics { burst: Some(burst), ..AgeingPhysics::default() });
        assert!(after(&mut a, 1000, 0.0, 1.9e5).crack.abs() < 1e-30);
        let crack = after(&mut a, 1000, 0.0, 3e5).crack;
        assert!((crack - 1e-15 * 1e5 * 0.1).abs() < 1e-15, "{crack}");
    }

    /// The share of time with water is slug / (slug + gap) = 0.25.
    #[test]
    fn water_blocks_its_share_of_the_time() {
        let water = WaterPhysics { depth: 0.5, mean_gap_s: 0.9, mean_slug_s: 0.3 };
        let mut a = ageing(AgeingPhysics { water: Some(water), ..AgeingPhysics::default() });
        let n = 20_000_000;
        let mut sum = 0.0;
        for k in 0..n {
            sum += 1.0 - a.step(f64::from(k) * H, 0.0, 0.0).passage;
        }
        let mean = sum / f64::from(n);
        assert!((mean - 0.125).abs() < 0.01, "{mean}");
    }
}
