//! `[chamber]`: the volume of a chamber, and how the joint's angle changes it.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

/// Either the cylindrical chamber of a continuum joint, of length l = h +- r q, or a vessel of
/// constant volume.
///
/// The absolute scale of the volume and that of the valve's opening cannot be told apart from
/// pressures alone: a volume that is wrong by a factor is answered by a fitted opening wrong by the
/// same factor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Chamber {
    /// Radius of the cylinder (delta in the paper), m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Length of the cylinder with the joint straight (h), m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Distance of the chamber's axis from the joint's axis (r), m; 0 for a chamber that does not
    /// bend.
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
            // Refused where a file has such a table; a value built in code without it has no
            // volume.
            _ => f64::NAN,
        }
    }

    /// Change of the volume per radian of the joint's angle, m^3/rad, for the chamber whose length
    /// grows with it.
    #[must_use]
    pub fn volume_per_rad_m3(&self) -> f64 {
        match (self.radius_m, self.offset_m) {
            (Some(radius), Some(offset)) => PI * radius * radius * offset,
            _ => 0.0,
        }
    }
}
