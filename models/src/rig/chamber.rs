//! `[chamber]`: the volume of a chamber, and how the joint's angle changes it.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::RigError;
use super::check::Checker;

/// Either the cylindrical chamber of a continuum joint, of length l = h +- r q, or a vessel of constant volume.
///
/// The absolute scale of the volume and that of the valve's opening cannot be told apart from pressures alone: a volume
/// that is wrong by a factor is answered by a fitted opening wrong by the same factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chamber {
    /// Radius of the cylinder (delta in the paper), m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Length of the cylinder with the joint straight (h), m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Distance of the chamber's axis from the joint's axis (r), m; 0 for a chamber that does not bend.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<f64>,
    /// Volume of a vessel that is no cylinder or does not bend, m^3; instead of the other keys.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume_m3: Option<f64>,
}

impl Chamber {
    /// Volume with the joint straight, m^3.
    #[must_use]
    pub fn rest_volume_m3(&self) -> f64 {
        match (self.volume_m3, self.radius_m, self.length_m) {
            (Some(volume), _, _) => volume,
            (None, Some(radius), Some(length)) => PI * radius * radius * length,
            // `check` refuses such a table; a value built in code without it has no volume.
            _ => f64::NAN,
        }
    }

    /// Change of the volume per radian of the joint's angle, m^3/rad, for the chamber whose length grows with it.
    #[must_use]
    pub fn volume_per_rad_m3(&self) -> f64 {
        match (self.radius_m, self.offset_m) {
            (Some(radius), Some(offset)) => PI * radius * radius * offset,
            _ => 0.0,
        }
    }

    pub(super) fn check(&self, checker: &Checker<'_>) -> Result<(), RigError> {
        let size = |key, value: Option<f64>, range| {
            value.map_or(Ok(()), |v| checker.within(key, v, range, "m", "it is in metres"))
        };
        size("chamber.radius_m", self.radius_m, (5e-4, 2.0))?;
        size("chamber.length_m", self.length_m, (5e-4, 10.0))?;
        size("chamber.offset_m", self.offset_m, (0.0, 2.0))?;
        if let Some(volume) = self.volume_m3 {
            let advice = "it is in cubic metres: 1 litre is 0.001";
            checker.within("chamber.volume_m3", volume, (1e-8, 10.0), "m^3", advice)?;
        }
        match (self.volume_m3, self.radius_m, self.length_m) {
            (Some(_), None, None) if self.offset_m.is_none() => Ok(()),
            (Some(_), _, _) => Err(checker.inconsistent(
                "[chamber] has volume_m3 and a cylinder's radius_m, length_m or offset_m; keep one description",
            )),
            (None, Some(_), Some(_)) => Ok(()),
            (None, _, _) => Err(checker.inconsistent(
                "[chamber] needs radius_m and length_m (and offset_m where a joint bends it), or volume_m3 alone",
            )),
        }
    }
}
