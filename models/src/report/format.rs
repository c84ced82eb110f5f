//! Numbers as readers want them.

/// `value` with `digits` significant digits, without an exponent where a person would not write
/// one.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return if value.is_nan() { "n/a".to_owned() } else { value.to_string() };
    }
    if value.abs() < f64::MIN_POSITIVE {
        return "0".to_owned();
    }
    // Finite and not zero: the exponent is within +-308.
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let wanted = i32::try_from(digits).unwrap_or(i32::MAX).saturating_sub(1).saturating_sub(exponent);
    format!("{value:.*}", usize::try_from(wanted).unwrap_or(0))
}

/// `value` with `decimals` decimals; "n/a" when there is none.
#[must_use]
pub fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "n/a".to_owned() }
}

/// The unit as it stands behind a number: with a space before it, and nothing where it is 1.
#[must_use]
pub fn behind(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A duration in the unit that suits it: 37 ns, 1.2 ms, 3.4 s.
#[must_use]
pub fn duration_text(seconds: f64) -> String {
    let (factor, unit) = match seconds {
        s if s < 1e-6 => (1e9, "ns"),
        s if s < 1e-3 => (1e6, "us"),
        s if s < 1.0 => (1e3, "ms"),
        _ => (1.0, "s"),
    };
    format!("{} {unit}", significant(seconds * factor, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_size() {
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(significant(12.345, 3), "12.3");
        assert_eq!(significant(-0.001_234, 3), "-0.00123");
        assert_eq!(significant(1.5e-9, 3), "1.50e-9");
        assert_eq!(significant(f64::NAN, 3), "n/a");
        assert_eq!([behind("kPa"), behind("1")], [" kPa", ""]);
        assert_eq!(duration_text(3.7e-8), "37.0 ns");
        assert_eq!(duration_text(0.0123), "12.3 ms");
        assert_eq!(duration_text(95.0), "95.0 s");
    }
}
