//! What the host takes from the rig file: limits and calibration of the channels.
//!
//! The file itself is [`pneudrive_rig`]'s.

mod left_out;
mod too_many;

pub use left_out::{LeftOut, left_out};
pub use pneudrive_rig::{Bus, Rig, RigError, Sensor, Unit};
pub use too_many::{TooMany, few_enough};

use crate::Calibration;
use crate::poller::{BaudChoice, ChannelLimit, LimitError, Limits};
use pneudrive_protocol::{CHANNELS, ScaleError, SensorScale};
use thiserror::Error;

/// Part of the nominal sensor's counts that its full scale takes, from the zero on: 4 V of 5 V.
const SPAN_COUNTS: f64 = 0.8 * 1024.0;

/// A calibration that the boards' sensors cannot have.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The boards' converters are others.
    #[error(
        "{file}:{line}: sensor.bits = {bits}: expected 10, because counts on the bus have 10 bits; leave [sensor] out of the rig \
         file of boards, or give its numbers for 10 bits"
    )]
    Bits {
        /// The file.
        file: String,
        /// The line of `sensor.bits`.
        line: usize,
        /// Its value.
        bits: u32,
    },
    /// The numbers are no scale of 10-bit counts.
    #[error("{file}:{line}: [{table}]: {error}")]
    Scale {
        /// The file.
        file: String,
        /// The line of the table.
        line: usize,
        /// The table.
        table: String,
        /// What is wrong.
        error: ScaleError,
    },
}

/// The line rate that `rig` says, if it says one: `baud` under `[bus]`.
pub fn baud(rig: &Rig) -> Option<BaudChoice> {
    let bus = rig.bus();
    bus.baud_auto.then_some(BaudChoice::Auto).or(bus.baud.map(BaudChoice::Rate))
}

/// The limits that `rig` sets; no limits without one.
///
/// # Errors
/// None for a file that was read: its limits are in range.
pub fn limits(rig: &Rig) -> Result<Limits, LimitError> {
    let limit = |limit: pneudrive_rig::Limit| ChannelLimit {
        max_kpa: limit.max_kpa.unwrap_or(f64::INFINITY),
        max_rate_kpa_s: limit.max_rate_kpa_s.unwrap_or(f64::INFINITY),
    };
    let mut limits = Limits::everywhere(limit(rig.usual_limit()))?;
    for board in rig.boards() {
        for channel in 0..CHANNELS {
            limits.set(board, channel, limit(rig.limit(board, channel)))?;
        }
    }
    Ok(limits)
}

/// What `rig` says of the sensors; the nominal scale where it says nothing.
///
/// # Errors
/// Numbers that no sensor behind a 10-bit converter has, with their line.
pub fn calibration(rig: &Rig) -> Result<Calibration, CalibrationError> {
    if let Some(bits) = rig.sensor_bits().filter(|&bits| bits != 10) {
        let line = rig.line("sensor.bits").unwrap_or(1);
        return Err(CalibrationError::Bits { file: rig.file().to_owned(), line, bits });
    }
    let usual = rig.usual_sensor().map_or(Ok(SensorScale::ORIGINAL), |sensor| {
        scale(sensor).map_err(|error| refused(rig, ("sensor".to_owned(), 1), error))
    })?;
    let mut calibration = Calibration::from(usual);
    for board in rig.boards() {
        let mut scales = [usual; CHANNELS];
        for (channel, own) in scales.iter_mut().enumerate() {
            let Some(sensor) = rig.sensor(board, channel) else { continue };
            *own = scale(sensor)
                .map_err(|error| refused(rig, rig.sensor_place(board, channel).unwrap_or_default(), error))?;
        }
        if scales != [usual; CHANNELS] {
            calibration = calibration.with_board(board, scales);
        }
    }
    Ok(calibration)
}

fn refused(rig: &Rig, (table, _): (String, usize), error: ScaleError) -> CalibrationError {
    let line = rig.line(&table).unwrap_or(1);
    CalibrationError::Scale { file: rig.file().to_owned(), line, table, error }
}

/// The nominal sensor's span, or as much of it as 1023 counts hold.
fn scale(sensor: pneudrive_rig::Sensor) -> Result<SensorScale, ScaleError> {
    let pneudrive_rig::Sensor { zero_counts, kpa_per_count } = sensor;
    let counts = SPAN_COUNTS.min(1023.0 - zero_counts);
    // The file has the nominal numbers with fewer digits.
    let nominal = SensorScale::ORIGINAL;
    let is_nominal = (zero_counts - nominal.zero_counts()).abs() < 1e-6
        && (kpa_per_count - nominal.kpa_per_count()).abs() < 1e-6;
    if is_nominal {
        Ok(nominal)
    } else {
        SensorScale::new(zero_counts, kpa_per_count, counts * kpa_per_count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(text: &str) -> Rig {
        Rig::parse("rig.toml", text).unwrap()
    }

    /// The rig file's own number of channels is the bus's.
    #[test]
    fn a_board_has_as_many_channels_as_a_packet() {
        assert_eq!(pneudrive_rig::CHANNELS, CHANNELS);
    }

    #[test]
    fn limits_of_the_file_hold_for_their_channels() {
        let limits =
            limits(&rig("[limits]\nmax_kpa = 300\n[boards.0.channels.3.limits]\nmax_kpa = 100\n")).unwrap();
        assert_eq!(
            (limits.of(0)[0].max_kpa, limits.of(0)[3].max_kpa, limits.of(7)[3].max_kpa),
            (300.0, 100.0, 300.0)
        );
        assert_eq!(super::limits(&rig("")).unwrap(), Limits::default());
    }

    #[test]
    fn a_line_rate_is_a_number_or_auto() {
        assert_eq!(baud(&rig("[bus]\nbaud = \"auto\"\n")), Some(BaudChoice::Auto));
        assert_eq!(baud(&rig("[bus]\nbaud = 2000000\n")), Some(BaudChoice::Rate(2_000_000)));
        assert_eq!(baud(&rig("")), None);
    }

    #[test]
    fn a_channels_own_calibration_holds_and_the_nominal_one_elsewhere() {
        let text = "[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.841645\n\
                    [boards.1.channels.2.sensor]\nzero_counts = 104.0\nkpa_per_count = 0.85\n";
        let calibration = calibration(&rig(text)).unwrap();
        assert_eq!(calibration.usual(), SensorScale::ORIGINAL);
        assert_eq!(calibration.of(0), [SensorScale::ORIGINAL; 4]);
        assert_eq!(calibration.channel(1, 1), SensorScale::ORIGINAL);
        let own = calibration.channel(1, 2);
        assert_eq!((own.zero_counts(), own.kpa_per_count()), (104.0, 0.85));
        assert!((own.full_scale_kpa() - 819.2 * 0.85).abs() < 1e-9);
        assert_eq!(super::calibration(&rig("")).unwrap(), Calibration::default());
    }

    #[test]
    fn what_no_board_has_is_refused_with_its_line() {
        let refused = |text: &str| calibration(&rig(text)).unwrap_err().to_string();
        let bits = refused("\n[sensor]\nbits = 12\nzero_counts = 409.6\nkpa_per_count = 0.21\n");
        assert!(bits.starts_with("rig.toml:3: sensor.bits = 12: expected 10"), "{bits}");
        let zero = refused("[boards.0.sensor]\nzero_counts = -3.0\nkpa_per_count = 0.84\n");
        assert_eq!(
            zero,
            "rig.toml:1: [boards.0.sensor]: sensor zero is -3 counts; it must be a number from 0 to 1023"
        );
        let usual = refused("\n[sensor]\nbits = 10\nzero_counts = 2000.0\nkpa_per_count = 0.84\n");
        assert!(usual.starts_with("rig.toml:2: [sensor]: sensor zero is 2000 counts"), "{usual}");
    }
}
