//! The unit in which people see pressures.

/// A unit of gauge pressure. Files and the bus have kPa; this is for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Kilopascal.
    #[default]
    Kpa,
    /// Bar: 100 kPa.
    Bar,
    /// Pound per square inch: 6.894757 kPa.
    Psi,
}

impl Unit {
    /// Every unit's name.
    pub const NAMES: [&'static str; 3] = ["kPa", "bar", "psi"];

    /// The unit with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "kPa" => Some(Self::Kpa),
            "bar" => Some(Self::Bar),
            "psi" => Some(Self::Psi),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Kpa => "kPa",
            Self::Bar => "bar",
            Self::Psi => "psi",
        }
    }

    /// One of it in kPa.
    #[must_use]
    pub fn kpa(self) -> f64 {
        match self {
            Self::Kpa => 1.0,
            Self::Bar => 100.0,
            // One pound-force on a square inch: 4.448221615 N / 6.4516e-4 m^2.
            Self::Psi => 6.894_757_293,
        }
    }

    /// Decimals that show a pressure to about 0.1 kPa, an eighth of a sensor count.
    #[must_use]
    pub fn decimals(self) -> usize {
        match self {
            Self::Kpa => 1,
            Self::Bar => 3,
            Self::Psi => 2,
        }
    }

    /// A pressure in kPa as a number of this unit.
    #[must_use]
    pub fn of_kpa(self, kpa: f64) -> f64 {
        kpa / self.kpa()
    }

    /// A pressure in kPa as text, without the unit.
    #[must_use]
    pub fn number(self, kpa: f64) -> String {
        let text = format!("{:.*}", self.decimals(), self.of_kpa(kpa));
        // A pressure that rounds to 0 has no sign.
        match text.strip_prefix('-') {
            Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
            _ => text,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_in_each_unit() {
        let say = |unit: Unit, kpa| format!("{} {}", unit.number(kpa), unit.name());
        assert_eq!(say(Unit::Kpa, 100.04), "100.0 kPa");
        assert_eq!(say(Unit::Bar, 100.04), "1.000 bar");
        assert_eq!(say(Unit::Psi, 689.475_73), "100.00 psi");
        assert_eq!(say(Unit::Kpa, -0.04), "0.0 kPa");
        assert_eq!(say(Unit::Bar, -1.0), "-0.010 bar");
        for name in Unit::NAMES {
            assert_eq!(Unit::named(name).map(Unit::name), Some(name));
        }
        assert_eq!(Unit::named("KPA"), None);
    }
}
