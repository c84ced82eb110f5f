//! Units of foreign columns: each is a factor to the format's own unit, some need the rig or the
//! air pressure.

use crate::ChannelId;
use crate::rig::Rig;
use pneudrive_plant::board::{Controller, Sensor};

/// What a target column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// kPa gauge.
    Pressure,
    /// 1, full drive.
    Drive,
    /// rad.
    Angle,
    /// s.
    Time,
}

/// A unit as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unit {
    /// `target = value * factor`.
    Factor(f64),
    /// `target = value * factor - air pressure`: an absolute pressure.
    Absolute(f64),
    /// Converter counts: of the pressure sensor for pressures, of the controller's drive for
    /// drives.
    Counts,
}

/// What some units need to become the format's.
#[derive(Debug, Clone, Default)]
pub(crate) struct UnitContext {
    /// What a pressure count is.
    pub sensor: Option<Sensor>,
    /// What a full drive is in counts.
    pub controller: Option<Controller>,
    /// Air pressure that absolute pressures are reduced by, kPa.
    pub ambient_kpa_abs: f64,
}

impl UnitContext {
    /// For a column of a channel, or of the whole rig.
    pub(crate) fn of(rig: &Rig, channel: Option<ChannelId>) -> Self {
        let rig = channel.map_or_else(|| rig.clone(), |channel| rig.at(channel));
        let ambient_kpa_abs = rig.ambient_or_standard().pressure_kpa_abs;
        Self { sensor: rig.sensor, controller: rig.controller, ambient_kpa_abs }
    }
}

/// Named factors. Pressures to kPa: 1 psi = 1 lbf/in^2, cmH2O at 4 degrees Celsius and mmHg as
/// defined in ISO 80000-4's conversion annex.
const PRESSURES: [(&str, f64); 8] = [
    ("kPa", 1.0),
    ("Pa", 1e-3),
    ("hPa", 0.1),
    ("MPa", 1e3),
    ("bar", 100.0),
    ("mbar", 0.1),
    ("psi", 6.894_757_293_168),
    ("cmH2O", 0.098_066_5),
];
const MMHG: (&str, f64) = ("mmHg", 0.133_322_387_415);
const DRIVES: [(&str, f64); 2] = [("1", 1.0), ("percent", 0.01)];
const ANGLES: [(&str, f64); 2] = [("rad", 1.0), ("deg", std::f64::consts::PI / 180.0)];
const TIMES: [(&str, f64); 5] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9), ("min", 60.0)];

impl Quantity {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Pressure => "a pressure",
            Self::Drive => "a drive",
            Self::Angle => "an angle",
            Self::Time => "a time",
        }
    }

    pub(crate) fn base(self) -> &'static str {
        match self {
            Self::Pressure => "kPa",
            Self::Drive => "full drive",
            Self::Angle => "rad",
            Self::Time => "s",
        }
    }

    fn factors(self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Pressure => PRESSURES.into_iter().chain([MMHG]).collect(),
            Self::Drive => DRIVES.to_vec(),
            Self::Angle => ANGLES.to_vec(),
            Self::Time => TIMES.to_vec(),
        }
    }

    /// The units that `parse` knows, for messages.
    pub(crate) fn allowed(self) -> String {
        let mut names: Vec<String> = self.factors().iter().map(|(name, _)| (*name).to_owned()).collect();
        match self {
            Self::Pressure => {
                names.extend(["kPa-abs (any of these with -abs)".to_owned(), "counts".to_owned()])
            }
            Self::Drive => names.push("counts".to_owned()),
            Self::Angle | Self::Time => {}
        }
        names.join(", ")
    }

    /// The unit named `text`, in any letter case unless that would be ambiguous, or a number: how
    /// many of the source make one of the target.
    pub(crate) fn unit(self, text: &str) -> Option<Unit> {
        let factors = self.factors();
        let named = |name: &str| {
            let exact = factors.iter().find(|(n, _)| *n == name);
            // "mpa" could be MPa or mPa: only names that are unique without case are taken without
            // case.
            let folded = || {
                let mut hits = factors.iter().filter(|(n, _)| n.eq_ignore_ascii_case(name));
                hits.next().filter(|(n, _)| *n != "MPa")
            };
            exact.or_else(folded).map(|(_, factor)| *factor)
        };
        if let Some(factor) = named(text) {
            return Some(Unit::Factor(factor));
        }
        if matches!(self, Self::Pressure | Self::Drive) && text.eq_ignore_ascii_case("counts") {
            return Some(Unit::Counts);
        }
        if self == Self::Pressure
            && let Some(factor) = text.strip_suffix("-abs").and_then(named)
        {
            return Some(Unit::Absolute(factor));
        }
        if self == Self::Drive && text == "%" {
            return Some(Unit::Factor(0.01));
        }
        let per_one: f64 = text.parse().ok()?;
        (per_one.is_finite() && per_one.abs() > 0.0).then(|| Unit::Factor(per_one.recip()))
    }
}

/// `target = value * factor + shift`, all of a mapping's conversion in two numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Linear {
    pub factor: f64,
    pub shift: f64,
}

impl Linear {
    pub(crate) fn apply(self, value: f64) -> f64 {
        value * self.factor + self.shift
    }
}

impl Unit {
    /// The conversion to the format's unit after `offset` (in the source's unit) is taken off; the
    /// missing table's name if counts are used without it.
    pub(crate) fn conversion(
        self,
        quantity: Quantity,
        offset: f64,
        context: &UnitContext,
    ) -> Result<Linear, &'static str> {
        let (factor, shift) = match (self, quantity) {
            (Self::Factor(factor), _) => (factor, 0.0),
            (Self::Absolute(factor), _) => (factor, -context.ambient_kpa_abs),
            (Self::Counts, Quantity::Drive) => {
                let controller = context.controller.as_ref().ok_or("[controller] saturation")?;
                (controller.saturation.recip(), 0.0)
            }
            (Self::Counts, _) => {
                let sensor = context.sensor.as_ref().ok_or("[sensor]")?;
                (sensor.kpa_per_count, -sensor.zero_counts * sensor.kpa_per_count)
            }
        };
        Ok(Linear { factor, shift: shift - offset * factor })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn to_target(quantity: Quantity, unit: &str, value: f64) -> f64 {
        let context = UnitContext {
            sensor: Some(Sensor { bits: 10, zero_counts: 102.4, kpa_per_count: 0.841_645 }),
            controller: Some(Controller { rate_hz: 1e3, kp: 10.0, kd: 0.0, saturation: 400.0, filter: 0.0 }),
            ambient_kpa_abs: 101.325,
        };
        let unit = quantity.unit(unit).unwrap_or_else(|| panic!("{unit} is unknown"));
        unit.conversion(quantity, 0.0, &context).unwrap().apply(value)
    }

    #[test]
    fn every_unit_gives_the_published_value() {
        for (quantity, unit, value, target) in [
            // 100 psi is 689.4757 kPa (the sensor's data sheet).
            (Quantity::Pressure, "psi", 100.0, 689.475_729),
            (Quantity::Pressure, "bar", 5.5, 550.0),
            (Quantity::Pressure, "mbar", 1013.25, 101.325),
            (Quantity::Pressure, "Pa", 101_325.0, 101.325),
            (Quantity::Pressure, "kPa", 7.0, 7.0),
            (Quantity::Pressure, "MPa", 0.7, 700.0),
            (Quantity::Pressure, "cmH2O", 20.0, 1.961_33),
            (Quantity::Pressure, "mmHg", 760.0, 101.325_014),
            (Quantity::Pressure, "bar-abs", 1.01325, 0.0),
            (Quantity::Pressure, "psi-abs", 14.695_949, 0.0),
            (Quantity::Pressure, "counts", 102.4, 0.0),
            (Quantity::Pressure, "counts", 1024.0 * 0.9, 689.475_58),
            (Quantity::Drive, "percent", -50.0, -0.5),
            (Quantity::Drive, "%", 25.0, 0.25),
            (Quantity::Drive, "counts", -400.0, -1.0),
            (Quantity::Drive, "255", 51.0, 0.2),
            (Quantity::Angle, "deg", 180.0, std::f64::consts::PI),
            (Quantity::Time, "ms", 1500.0, 1.5),
            (Quantity::Time, "us", 2e6, 2.0),
        ] {
            let got = to_target(quantity, unit, value);
            assert!((got - target).abs() < 1e-5, "{value} {unit} -> {got}, expected {target}");
        }
    }

    #[test]
    fn an_offset_is_in_the_source_unit() {
        let unit = Quantity::Pressure.unit("psi").unwrap();
        let conversion = unit.conversion(Quantity::Pressure, 14.7, &UnitContext::default()).unwrap();
        assert!(conversion.apply(14.7).abs() < 1e-12);
        assert!((conversion.apply(15.7) - 6.894_757).abs() < 1e-5);
    }

    #[test]
    fn ambiguous_and_foreign_units_are_refused() {
        assert_eq!(Quantity::Pressure.unit("mPa"), None);
        assert_eq!(Quantity::Pressure.unit("ms"), None);
        assert_eq!(Quantity::Time.unit("psi"), None);
        assert_eq!(Quantity::Time.unit("0"), None);
        assert_eq!(Quantity::Pressure.unit("PSI"), Quantity::Pressure.unit("psi"));
    }
}
