//! Checks of a rig's parameters, each naming the field.

use super::error::PlantError;
use super::parameters::{GasModel, PlantParameters};

type Check = (&'static str, f64, &'static str, f64, f64, &'static str);

impl PlantParameters {
    /// Checks every field against the range in its documentation.
    ///
    /// # Errors
    /// Names the first field outside its range, its value and the range.
    pub fn validate(&self) -> Result<(), PlantError> {
        let (v, j, n) = (&self.valve, &self.joint, &self.nuisances);
        let checks: [Check; 23] = [
            ("channels", self.channels as f64, "1", 1.0, 1024.0, "1 to 1024"),
            ("step_ns", self.step_ns as f64, "ns", 1e3, 2e5, "1000 to 200000"),
            ("ambient.pressure_kpa_abs", self.ambient.pressure_kpa_abs, "kPa", 50.0, 120.0, "50 to 120"),
            ("ambient.temperature_k", self.ambient.temperature_k, "K", 250.0, 350.0, "250 to 350"),
            ("supply.pressure_kpa", self.supply.pressure_kpa, "kPa", 50.0, 1500.0, "50 to 1500"),
            ("chamber.radius_m", self.chamber.radius_m, "m", 1e-3, 0.2, "0.001 to 0.2"),
            ("chamber.length_m", self.chamber.length_m, "m", 5e-3, 2.0, "0.005 to 2"),
            ("chamber.offset_m", self.chamber.offset_m, "m", 0.0, 0.5, "0 to 0.5"),
            (
                "chamber.initial_kpa",
                self.chamber.initial_kpa,
                "kPa",
                0.0,
                self.supply.pressure_kpa,
                "0 to the supply pressure",
            ),
            (
                "valve.conductance_m3_per_s_pa",
                v.conductance_m3_per_s_pa,
                "m^3/(s Pa)",
                1e-11,
                1e-6,
                "1e-11 to 1e-6",
            ),
            ("valve.fill_edge", v.fill_edge, "1", -0.5, 0.5, "-0.5 to 0.5"),
            ("valve.vent_edge", v.vent_edge, "1", -0.5, 0.5, "-0.5 to 0.5"),
            ("valve.corner", v.corner, "1", 1e-4, 0.5, "0.0001 to 0.5"),
            ("valve.leakage", v.leakage, "1", 0.0, 0.2, "0 to 0.2"),
            ("valve.spool_time_constant_s", v.spool_time_constant_s, "s", 0.0, 1.0, "0 to 1"),
            ("joint.angle_rad_per_mpa", j.angle_rad_per_mpa, "rad/MPa", 0.0, 5.0, "0 to 5"),
            ("joint.natural_frequency_hz", j.natural_frequency_hz, "Hz", 0.05, 50.0, "0.05 to 50"),
            ("joint.damping_ratio", j.damping_ratio, "1", 0.01, 10.0, "0.01 to 10"),
            ("sensor.noise_kpa", self.sensor.noise_kpa, "kPa", 0.0, 20.0, "0 to 20"),
            ("sensor.adc_bits", f64::from(self.sensor.adc_bits), "bits", 8.0, 12.0, "8 to 12"),
            ("nuisances.supply_wander", n.supply_wander, "1", 0.0, 0.2, "0 to 0.2"),
            ("nuisances.supply_wander_time_s", n.supply_wander_time_s, "s", 0.5, 1e6, "0.5 or more"),
            ("nuisances.spread", n.spread, "1", 0.0, 0.3, "0 to 0.3"),
        ];
        let background =
            n.background.checks().map(|(name, value, max, expected)| (name, value, "1", 0.0, max, expected));
        for (name, value, unit, min, max, expected) in checks.into_iter().chain(background) {
            if !(min..=max).contains(&value) {
                return Err(PlantError::Parameter { name, value, unit, expected });
            }
        }
        self.validate_gas()?;
        self.validate_joint_travel()
    }

    fn validate_gas(&self) -> Result<(), PlantError> {
        match self.gas {
            GasModel::FixedTemperature { polytropic_exponent: n } if !(1.0..=1.67).contains(&n) => {
                Err(PlantError::Parameter {
                    name: "gas.polytropic_exponent",
                    value: n,
                    unit: "1",
                    expected: "1 to 1.67",
                })
            }
            // Not `< 0.002`: a NaN must not pass.
            GasModel::EnergyBalance { wall_time_constant_s: t } if t.is_nan() || t < 0.002 => {
                Err(PlantError::Parameter {
                    name: "gas.wall_time_constant_s",
                    value: t,
                    unit: "s",
                    expected: "0.002 or more (infinite: adiabatic)",
                })
            }
            _ => Ok(()),
        }
    }

    /// A chamber must keep a length when its neighbour is at full supply pressure, overshoot
    /// included.
    fn validate_joint_travel(&self) -> Result<(), PlantError> {
        let travel =
            self.joint.angle_rad_per_mpa * 1e-3 * self.supply.pressure_kpa * self.chamber.offset_m * 2.0;
        if self.joint.free && travel >= self.chamber.length_m {
            return Err(PlantError::Parameter {
                name: "joint.angle_rad_per_mpa",
                value: self.joint.angle_rad_per_mpa,
                unit: "rad/MPa",
                expected: "less than chamber.length_m / (2 offset_m supply pressure in MPa): a chamber would lose its length",
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_valid() {
        PlantParameters::default().validate().unwrap();
    }

    #[test]
    fn refusals_name_field_value_and_range() {
        let mut p = PlantParameters::default();
        p.valve.corner = 0.0;
        let text = p.validate().unwrap_err().to_string();
        assert!(text.contains("valve.corner") && text.contains("0.0001 to 0.5"), "{text}");
        let mut p = PlantParameters::default();
        p.ambient.temperature_k = f64::NAN;
        assert!(p.validate().unwrap_err().to_string().contains("ambient.temperature_k is NaN K"));
        let gas = GasModel::EnergyBalance { wall_time_constant_s: f64::NAN };
        let p = PlantParameters { gas, ..PlantParameters::default() };
        assert!(p.validate().unwrap_err().to_string().contains("gas.wall_time_constant_s"));
        let p = PlantParameters { channels: 0, ..PlantParameters::default() };
        assert!(p.validate().unwrap_err().to_string().contains("channels is 0"));
        let mut p = PlantParameters::default();
        p.joint.free = true;
        p.joint.angle_rad_per_mpa = 5.0;
        assert!(p.validate().unwrap_err().to_string().contains("joint.angle_rad_per_mpa"));
    }
}
