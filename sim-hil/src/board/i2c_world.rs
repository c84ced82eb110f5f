//! What sensors on a board's I2C connector have before them, with their noise.

use crate::bus::{Air, JointNow};
use crate::plant::noise::{Purpose, normal, stream};
use rand_chacha::ChaCha8Rng;

/// What is on a board's I2C connector. Nothing by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct I2cConfig {
    /// A transducer for the supply pressure, behind an ADS1115.
    pub supply: bool,
    /// An IMU of the kind BMI323, on the end plate of the board's joint.
    pub imu: bool,
    /// Of their noise, which also depends on the board's position.
    pub seed: u64,
}

/// The supply and the joint of one board, as its sensors measure them.
#[derive(Debug)]
pub(super) struct I2cWorld {
    position: u8,
    supply_noise: ChaCha8Rng,
    imu_noise: ChaCha8Rng,
}

impl I2cWorld {
    /// Standard deviation of a reading of the supply, Pa: 0.03 % of a transducer of 1 MPa.
    const SUPPLY_NOISE_PA: f64 = 300.0;
    /// The BMI323's noise densities of 180 ug and 0.007 degrees/s per root Hz, over 50 Hz: m/s^2
    /// and rad/s.
    const ACCELERATION_NOISE: f64 = 0.0125;
    const RATE_NOISE: f64 = 0.000_86;
    const GRAVITY_M_S2: f64 = 9.806_65;

    pub(super) fn new(seed: u64, position: u8) -> Self {
        // Place 0 of the supply sensor's noise is that of recordings without a bus.
        let noise = |purpose| stream(seed, purpose, usize::from(position) + 1);
        Self { position, supply_noise: noise(Purpose::SupplySensor), imu_noise: noise(Purpose::Imu) }
    }

    /// The supply pressure, Pa gauge; `None` where there is no supply.
    pub(super) fn supply_pa(&mut self, now_ns: u64, air: &mut dyn Air) -> Option<f64> {
        let noise = Self::SUPPLY_NOISE_PA * normal(&mut self.supply_noise);
        air.supply_pa(now_ns).map(|pa| pa + noise)
    }

    /// Acceleration, gravity included, m/s^2, and angular rate, rad/s, along and about the part's
    /// axes.
    pub(super) fn motion(&mut self, now_ns: u64, air: &mut dyn Air) -> ([f64; 3], [f64; 3]) {
        let (acceleration, rate) = felt(air.joint(self.position, now_ns));
        let acceleration = acceleration.map(|a| a + Self::ACCELERATION_NOISE * normal(&mut self.imu_noise));
        (acceleration, rate.map(|w| w + Self::RATE_NOISE * normal(&mut self.imu_noise)))
    }
}

/// Acceleration, m/s^2, and angular rate, rad/s, on the end plate of a joint that stands upright: z
/// along its axis, bent by `q_u` about x, then by `q_v` about the new y. Gravity alone: what the
/// plate itself is accelerated by is left out.
fn felt(joint: JointNow) -> ([f64; 3], [f64; 3]) {
    let [(su, cu), (sv, cv)] = joint.angles_rad.map(f64::sin_cos);
    let [wu, wv] = joint.rates_rad_s;
    let acceleration = [-sv * cu, su, cv * cu].map(|share| share * I2cWorld::GRAVITY_M_S2);
    (acceleration, [wu * cv, wv, wu * sv])
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = I2cWorld::GRAVITY_M_S2;

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn gravity_is_felt_along_the_plates_own_axes() {
        let at = |angles_rad| felt(JointNow { angles_rad, rates_rad_s: [0.0; 2] }).0;
        near(at([0.0, 0.0]), [0.0, 0.0, G]);
        let quarter = std::f64::consts::FRAC_PI_2;
        near(at([quarter, 0.0]), [0.0, G, 0.0]);
        near(at([0.0, quarter]), [-G, 0.0, 0.0]);
        let tilted = at([0.3, -0.2]);
        assert!((tilted.iter().map(|a| a * a).sum::<f64>().sqrt() - G).abs() < 1e-12);
    }

    /// The rate is that at which gravity turns in the plate's axes: a' = a x w.
    #[test]
    fn the_rate_is_that_of_the_turning_plate() {
        let (angles, rates, step) = ([0.4, -0.3], [0.7, -1.1], 1e-6);
        let (before, w) = felt(JointNow { angles_rad: angles, rates_rad_s: rates });
        let later = [0, 1].map(|axis| angles[axis] + step * rates[axis]);
        let (after, _) = felt(JointNow { angles_rad: later, rates_rad_s: rates });
        let turned = [
            before[1] * w[2] - before[2] * w[1],
            before[2] * w[0] - before[0] * w[2],
            before[0] * w[1] - before[1] * w[0],
        ];
        for axis in 0..3 {
            let slope = (after[axis] - before[axis]) / step;
            assert!((slope - turned[axis]).abs() < 1e-4, "{axis}: {slope} {}", turned[axis]);
        }
    }
}
