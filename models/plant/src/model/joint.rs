//! Chamber volumes of a continuum joint with four cylindrical chambers.

use std::f64::consts::PI;

/// Geometry of a joint: four cylinders of one radius around a backbone. Bending by the angles
/// `(q_u, q_v)` lengthens one chamber of a pair and shortens the other: `l_0,1 = h +- r q_u`,
/// `l_2,3 = h +- r q_v`, `V_i = pi delta^2 l_i`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Radius `delta` of a chamber, m.
    pub radius_m: f64,
    /// Length `h` of a chamber of the straight joint, m.
    pub length_m: f64,
    /// Distance `r` of a chamber's axis from the backbone, m.
    pub offset_m: f64,
}

impl Joint {
    /// Volume in m^3 of chamber 0 to 3 at joint angles in rad. Negative when the angle is beyond
    /// what the geometry allows.
    #[must_use]
    pub fn volume_m3(&self, chamber: usize, qu_rad: f64, qv_rad: f64) -> f64 {
        let angle = if chamber < 2 { qu_rad } else { qv_rad };
        let sign = if chamber.is_multiple_of(2) { 1.0 } else { -1.0 };
        PI * self.radius_m.powi(2) * (self.length_m + sign * self.offset_m * angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_share_the_straight_volume() {
        let joint = Joint { radius_m: 0.024, length_m: 0.2, offset_m: 0.045 };
        let straight = joint.volume_m3(0, 0.0, 0.0);
        assert!((straight - 3.619_114_7e-4).abs() < 1e-10, "{straight}");
        // pi 0.024^2 (0.2 +- 0.045 * 0.5)
        assert!((joint.volume_m3(0, 0.5, 0.3) - 4.026_265e-4).abs() < 1e-9);
        assert!((joint.volume_m3(1, 0.5, 0.3) - 3.211_964e-4).abs() < 1e-9);
        for pair in [0, 2] {
            let sum = joint.volume_m3(pair, 0.5, 0.3) + joint.volume_m3(pair + 1, 0.5, 0.3);
            assert!((sum - 2.0 * straight).abs() < 1e-15);
        }
    }
}
