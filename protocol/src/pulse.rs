//! The 555 timer that enables a board's line driver.
//!
//! The first start bit of an answer triggers a monostable of t = 1.1 R C; the driver is enabled
//! while it lasts. It must outlast the ten bytes even when both parts are at the low end of their
//! tolerances, and end soon after, so that the host or another board can speak. Formula: 555
//! datasheet, monostable operation.

use crate::Baud;
use thiserror::Error;

/// The E96 series (IEC 60063), three significant digits of one decade.
#[rustfmt::skip]
pub const E96: [u16; 96] = [
    100, 102, 105, 107, 110, 113, 115, 118, 121, 124, 127, 130, 133, 137, 140, 143,
    147, 150, 154, 158, 162, 165, 169, 174, 178, 182, 187, 191, 196, 200, 205, 210,
    215, 221, 226, 232, 237, 243, 249, 255, 261, 267, 274, 280, 287, 294, 301, 309,
    316, 324, 332, 340, 348, 357, 365, 374, 383, 392, 402, 412, 422, 432, 442, 453,
    464, 475, 487, 499, 511, 523, 536, 549, 562, 576, 590, 604, 619, 634, 649, 665,
    681, 698, 715, 732, 750, 768, 787, 806, 825, 845, 866, 887, 909, 931, 953, 976,
];

/// Tolerances in parts per million.
const PPM: u64 = 1_000_000;

/// The timer's capacitor and the tolerances of both parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Capacitance, pF.
    pub capacitance_pf: u32,
    /// Tolerance of the capacitor, ppm.
    pub capacitor_tolerance_ppm: u32,
    /// Tolerance of the resistor, ppm.
    pub resistor_tolerance_ppm: u32,
}

impl Parts {
    /// The original's: 100 nF +- 5 % and a 1 % resistor.
    pub const ORIGINAL: Self =
        Self { capacitance_pf: 100_000, capacitor_tolerance_ppm: 50_000, resistor_tolerance_ppm: 10_000 };
}

impl Default for Parts {
    fn default() -> Self {
        Self::ORIGINAL
    }
}

/// How long the driver stays enabled, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulse {
    /// With both parts at their nominal values.
    pub nominal_ns: u64,
    /// With both parts at the low end: what the packet must fit into.
    pub shortest_ns: u64,
    /// With both parts at the high end: when the bus is free for certain.
    pub longest_ns: u64,
    /// Root sum of squares of the two tolerances: the +- figure that is usually quoted.
    pub tolerance_ns: u64,
}

/// No resistor of the series gives the pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PulseError {
    /// A part with no capacitance, or with a tolerance of 100 % or more.
    #[error(
        "a capacitor of {c} nF +- {dc} % and a resistor of +- {dr} %: the capacitance must be above 0 and both tolerances below 100 %",
        c = f64::from(parts.capacitance_pf) / 1e3,
        dc = f64::from(parts.capacitor_tolerance_ppm) / 1e4,
        dr = f64::from(parts.resistor_tolerance_ppm) / 1e4
    )]
    ImpossibleParts {
        /// The parts that were refused.
        parts: Parts,
    },
    /// The resistor would have to lie outside 100 ohm to 9.76 megohm.
    #[error(
        "{baud} baud needs a resistor of about {resistance_ohm} ohm, outside 100 to 9,760,000 ohm; choose another capacitor"
    )]
    NoResistor {
        /// The line rate, bit/s.
        baud: u32,
        /// The resistance that would do, ohm.
        resistance_ohm: u64,
    },
}

/// The pulse of a resistor (ohm) with these parts.
pub const fn pulse(resistance_ohm: u32, parts: Parts) -> Pulse {
    // ohm x pF = 1e-12 s = 1e-3 ns, times 1.1.
    let product = resistance_ohm as u64 * parts.capacitance_pf as u64;
    let nominal_ns = nominal_ns(product);
    let (r, c) = (parts.resistor_tolerance_ppm as u64, parts.capacitor_tolerance_ppm as u64);
    Pulse {
        nominal_ns,
        shortest_ns: part_of(part_of(nominal_ns, PPM.saturating_sub(r)), PPM.saturating_sub(c)),
        longest_ns: part_of(part_of(nominal_ns, PPM + r), PPM + c),
        tolerance_ns: part_of(nominal_ns, (r * r + c * c).isqrt()),
    }
}

/// The smallest E96 resistor (ohm) whose pulse still covers a packet with both parts at the low
/// end.
///
/// # Errors
/// Impossible parts, or a resistance outside five decades of the series (100 ohm to 9.76 megohm).
pub fn resistor_for(baud: Baud, parts: Parts) -> Result<u32, PulseError> {
    let possible = parts.capacitance_pf > 0
        && u64::from(parts.capacitor_tolerance_ppm) < PPM
        && u64::from(parts.resistor_tolerance_ppm) < PPM;
    if !possible {
        return Err(PulseError::ImpossibleParts { parts });
    }
    let covers = |ohm: u32| pulse(ohm, parts).shortest_ns >= baud.packet_ns();
    // Below 100 ohm the discharge transistor of the 555 carries too much current; a smaller
    // capacitor is the answer.
    let first = u32::from(E96[0]);
    let too_large_a_capacitor = covers(first);
    let decades = [1, 10, 100, 1_000, 10_000];
    let mut series =
        decades.into_iter().flat_map(|decade| E96.iter().map(move |&digits| u32::from(digits) * decade));
    match series.find(|&ohm| covers(ohm)) {
        Some(ohm) if !too_large_a_capacitor => Ok(ohm),
        _ => Err(PulseError::NoResistor { baud: baud.get(), resistance_ohm: ideal_ohm(baud, parts) }),
    }
}

const fn nominal_ns(ohm_picofarad: u64) -> u64 {
    ohm_picofarad * 11 / 10_000
}

/// `value` x `ppm` / 1e6 without overflow for values up to hours.
const fn part_of(value: u64, ppm: u64) -> u64 {
    value / PPM * ppm + value % PPM * ppm / PPM
}

/// The resistance whose nominal pulse is one packet, ohm: for the error message.
fn ideal_ohm(baud: Baud, parts: Parts) -> u64 {
    (baud.packet_ns() * 10_000 / 11).div_ceil(u64::from(parts.capacitance_pf))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_originals_pulse_is_107_plus_minus_5_us() {
        let pulse = pulse(976, Parts::ORIGINAL);
        assert_eq!(pulse.nominal_ns, 107_360);
        assert_eq!(pulse.tolerance_ns, 5_474);
        assert!(pulse.shortest_ns > 100_000 && pulse.longest_ns < 114_000, "{pulse:?}");
    }

    #[test]
    fn the_originals_resistor_is_the_smallest_that_covers_a_packet() {
        assert_eq!(resistor_for(Baud::ORIGINAL, Parts::ORIGINAL), Ok(976));
        assert!(pulse(953, Parts::ORIGINAL).shortest_ns < Baud::ORIGINAL.packet_ns());
    }

    #[test]
    fn every_chosen_resistor_covers_its_packet_and_no_smaller_one_does() {
        for rate in
            [9_600, 19_200, 57_600, 115_200, 230_400, 460_800, 921_600, 1_000_000, 2_000_000, 3_000_000]
        {
            let baud = Baud::new(rate).unwrap();
            let ohm = resistor_for(baud, Parts::ORIGINAL).unwrap();
            assert!(pulse(ohm, Parts::ORIGINAL).shortest_ns >= baud.packet_ns());
            // One step of the series is 2.4 %: nothing is wasted.
            assert!(
                pulse(ohm * 97 / 100, Parts::ORIGINAL).shortest_ns < baud.packet_ns(),
                "{rate} baud: {ohm} ohm"
            );
        }
    }

    #[test]
    fn the_series_is_ten_to_the_power_of_i_96ths() {
        for (i, &digits) in E96.iter().enumerate() {
            assert_eq!(f64::from(digits), (100.0 * 10f64.powf(i as f64 / 96.0)).round());
        }
    }

    #[test]
    fn what_has_no_answer_says_so() {
        let large = Parts { capacitance_pf: 100_000_000, ..Parts::ORIGINAL };
        let error = resistor_for(Baud::ORIGINAL, large).unwrap_err();
        assert_eq!(error, PulseError::NoResistor { baud: 1_000_000, resistance_ohm: 1 });
        let none = Parts { capacitance_pf: 0, ..Parts::ORIGINAL };
        let error = resistor_for(Baud::ORIGINAL, none).unwrap_err();
        assert_eq!(error, PulseError::ImpossibleParts { parts: none });
        let text = std::format!("{error}");
        assert!(text.starts_with("a capacitor of 0 nF +- 5 % and a resistor of +- 1 %: "), "{text}");
    }
}
