//! Motion of a continuum joint: two bending angles, each driven by the pressure difference of a
//! pair of chambers.
//!
//! `q'' = w^2 (c (p_a - p_b) - q) - 2 z w q'`. Pair 0/1 bends `q_u`, pair 2/3 bends `q_v`; the
//! chamber at the higher pressure lengthens: `l_0,1 = h +- r q_u`, `l_2,3 = h +- r q_v`.

use super::physics::JointPhysics;

/// State of one axis: angle, rad, and rate, rad/s.
pub const AXIS_STATES: usize = 2;
/// Axes of a board's joint.
pub const AXES: usize = 2;

/// Axis a channel acts on, and the sign with which a positive angle lengthens its chamber.
#[inline]
pub fn axis_of(channel_on_board: usize) -> (usize, f64) {
    (channel_on_board / 2, if channel_on_board.is_multiple_of(2) { 1.0 } else { -1.0 })
}

impl JointPhysics {
    /// Rates of an axis' angle and angular rate under a pressure difference in Pa.
    #[inline]
    pub fn rates(&self, angle: f64, rate: f64, difference_pa: f64) -> [f64; AXIS_STATES] {
        let w = self.angular_frequency;
        [rate, w * w * (self.angle_per_pa * difference_pa - angle) - 2.0 * self.damping_ratio * w * rate]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_push_against_each_other() {
        assert_eq!(axis_of(0), (0, 1.0));
        assert_eq!(axis_of(1), (0, -1.0));
        assert_eq!(axis_of(2), (1, 1.0));
        assert_eq!(axis_of(3), (1, -1.0));
    }

    #[test]
    fn rests_at_the_compliance() {
        let joint =
            JointPhysics { free: true, angle_per_pa: 1e-6, angular_frequency: 9.0, damping_ratio: 0.5 };
        let [rate, acceleration] = joint.rates(0.2, 0.0, 2e5);
        assert!(rate.abs() < 1e-15 && acceleration.abs() < 1e-12);
        assert!(joint.rates(0.2, 0.0, 3e5)[1] > 0.0);
    }
}
