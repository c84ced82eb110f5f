//! One `--map TARGET=SOURCE:UNIT[:OFFSET]` from the command line.

use super::ImportError;
use super::unit::{Quantity, Unit};
use crate::column::ColumnKind;

/// A column of the format and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    /// The text as given, for messages.
    pub text: String,
    /// Column of the format.
    pub target: String,
    /// Column of the foreign file: its name, or `#n` for the n-th.
    pub source: String,
    /// Unit of the foreign column.
    pub unit: Unit,
    /// Taken off the foreign value, in its own unit.
    pub offset: f64,
    pub(crate) quantity: Quantity,
}

const EXPECTED: &str = "TARGET=SOURCE:UNIT or TARGET=SOURCE:UNIT:OFFSET";
const EXAMPLE: &str = "b0_p0_kpa=Pressure (psi):psi";
const EXPECTED_TIME: &str = "SOURCE:UNIT";
const EXAMPLE_TIME: &str = "time [ms]:ms";

impl Mapping {
    /// Parses `TARGET=SOURCE:UNIT[:OFFSET]`. The source may itself contain colons.
    ///
    /// # Errors
    /// [`ImportError`], quoting the text.
    pub fn parse(text: &str) -> Result<Self, ImportError> {
        let wrong = |problem: &str| ImportError::Mapping {
            text: text.to_owned(),
            problem: problem.to_owned(),
            expected: EXPECTED,
            example: EXAMPLE,
        };
        let (target, rest) = text.split_once('=').ok_or_else(|| wrong("there is no ="))?;
        let target = target.trim();
        let quantity = match ColumnKind::parse(target) {
            Some(
                ColumnKind::Command(_)
                | ColumnKind::Pressure(_)
                | ColumnKind::Supply
                | ColumnKind::BoardSupply(_),
            ) => Quantity::Pressure,
            Some(ColumnKind::Spool(_) | ColumnKind::Fill(_) | ColumnKind::Vent(_)) => Quantity::Drive,
            Some(ColumnKind::JointU(_) | ColumnKind::JointV(_)) => Quantity::Angle,
            Some(ColumnKind::Time) => return Err(wrong("the time column is given with --time")),
            None => {
                return Err(ImportError::Target { text: text.to_owned(), target: target.to_owned() });
            }
        };
        let (source, unit, offset) = source_unit_offset(text, rest, quantity, wrong)?;
        Ok(Self { text: text.to_owned(), target: target.to_owned(), source, unit, offset, quantity })
    }

    /// Parses the `SOURCE:UNIT` of a time column.
    ///
    /// # Errors
    /// [`ImportError`], quoting the text.
    pub fn parse_time(text: &str) -> Result<Self, ImportError> {
        let wrong = |problem: &str| ImportError::Mapping {
            text: text.to_owned(),
            problem: problem.to_owned(),
            expected: EXPECTED_TIME,
            example: EXAMPLE_TIME,
        };
        let (source, unit, offset) = source_unit_offset(text, text, Quantity::Time, wrong)?;
        Ok(Self {
            text: text.to_owned(),
            target: "t_s".to_owned(),
            source,
            unit,
            offset,
            quantity: Quantity::Time,
        })
    }
}

fn source_unit_offset(
    text: &str,
    rest: &str,
    quantity: Quantity,
    wrong: impl Fn(&str) -> ImportError,
) -> Result<(String, Unit, f64), ImportError> {
    let (before, last) = rest.rsplit_once(':').ok_or_else(|| wrong("there is no :UNIT"))?;
    // SOURCE:UNIT:OFFSET only if what stands before the number is a unit: the source may hold
    // colons.
    let with_offset = || {
        let offset: f64 = last.trim().parse().ok().filter(|o: &f64| o.is_finite())?;
        let (source, unit) = before.rsplit_once(':')?;
        Some((source, quantity.unit(unit.trim())?, offset))
    };
    let (source, unit, offset) = match with_offset() {
        Some(parsed) => parsed,
        None => {
            let unit = quantity.unit(last.trim()).ok_or_else(|| ImportError::Unit {
                text: text.to_owned(),
                unit: last.trim().to_owned(),
                quantity: quantity.name(),
                allowed: quantity.allowed(),
                base: quantity.base(),
            })?;
            (before, unit, 0.0)
        }
    };
    if source.trim().is_empty() {
        return Err(wrong("the source column is empty"));
    }
    Ok((source.trim().to_owned(), unit, offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> (String, String, Unit, f64) {
        let m = Mapping::parse(text).unwrap_or_else(|e| panic!("{e}"));
        (m.target, m.source, m.unit, m.offset)
    }

    #[test]
    fn names_with_spaces_parentheses_and_colons_work() {
        let psi = Quantity::Pressure.unit("psi").unwrap();
        assert_eq!(
            parsed("b0_p0_kpa=Pressure (psi):psi"),
            ("b0_p0_kpa".into(), "Pressure (psi)".into(), psi, 0.0)
        );
        assert_eq!(parsed("b0_p0_kpa=AI:1:psi:14.7"), ("b0_p0_kpa".into(), "AI:1".into(), psi, 14.7));
        assert_eq!(
            parsed("b1_u3=PWM:255:127.5"),
            ("b1_u3".into(), "PWM".into(), Unit::Factor(1.0 / 255.0), 127.5)
        );
        assert_eq!(parsed("b1_u3=#4:percent").1, "#4");
    }

    #[test]
    fn mistakes_are_named() {
        let message = |text: &str| Mapping::parse(text).unwrap_err().to_string();
        assert!(message("b0_p0_kpa").contains("there is no ="));
        assert!(message("b0_p0_kpa=x").contains("there is no :UNIT"));
        assert!(message("b0_p0_psi=x:psi").contains("b0_p0_psi is not a column of the format"));
        assert!(
            message("b0_p0_kpa=x:percent")
                .contains("percent is not a unit of a pressure; use one of kPa, Pa,")
        );
        assert!(message("t_s=x:s").contains("--time"));
        let time = Mapping::parse_time("time [ms]:ms").unwrap();
        assert_eq!((time.source.as_str(), time.unit), ("time [ms]", Unit::Factor(1e-3)));
    }
}
