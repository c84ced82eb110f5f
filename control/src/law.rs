use crate::ValveDrive;
use crate::sample::{FRACTION_BITS, FineCounts};

/// The original's control law: drive = kp (command - pressure) - kd (pressure - previous pressure).
///
/// `kd` acts on the change between two control steps, so its meaning depends on the loop period.
#[derive(Debug, Clone)]
pub(crate) struct ControlLaw {
    kp: i32,
    kd: i32,
    saturation: i32,
}

impl ControlLaw {
    /// Gains up to [`GAIN_MAX`](Self::GAIN_MAX), saturation 1 to 400.
    pub(crate) fn new(kp: u16, kd: u16, saturation: u16) -> Self {
        Self { kp: i32::from(kp), kd: i32::from(kd), saturation: i32::from(saturation) }
    }

    /// Two products of a gain and a pressure of 18 bits each stay below 2^30.
    pub(crate) const GAIN_MAX: u16 = 1_000;

    /// The drive for this step, rounded to the nearest drive count.
    pub(crate) fn drive(
        &self,
        command: FineCounts,
        pressure: FineCounts,
        previous: FineCounts,
    ) -> ValveDrive {
        const HALF: i32 = 1 << (FRACTION_BITS - 1);
        let error = command.raw() - pressure.raw();
        let change = pressure.raw() - previous.raw();
        let drive = (self.kp * error - self.kd * change + HALF) >> FRACTION_BITS;
        ValveDrive::saturating(drive.clamp(-self.saturation, self.saturation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Counts;

    fn fine(counts: u16) -> FineCounts {
        FineCounts::from_counts(Counts::new(counts).unwrap())
    }

    fn original_law() -> ControlLaw {
        ControlLaw::new(10, 20, 400)
    }

    #[test]
    fn the_originals_numbers() {
        // (command, pressure, previous) -> 10 (command - pressure) - 20 (pressure - previous),
        // +-400
        let table = [
            ((500, 500, 500), 0),
            ((540, 500, 500), 400),
            ((539, 500, 500), 390),
            ((460, 500, 500), -400),
            ((520, 500, 495), 100),
            ((520, 500, 490), 0),
            ((520, 500, 470), -400),
            ((500, 500, 503), 60),
            ((1023, 0, 0), 400),
        ];
        for ((command, pressure, previous), drive) in table {
            let got = original_law().drive(fine(command), fine(pressure), fine(previous));
            assert_eq!(got.get(), drive, "command {command}, pressure {pressure}, previous {previous}");
        }
    }

    #[test]
    fn fractions_of_a_count_drive_the_valve() {
        // A quarter count of error is 2.5 drive counts.
        let pressure = FineCounts::from_raw(fine(500).raw() - 64);
        assert_eq!(original_law().drive(fine(500), pressure, pressure).get(), 3);
    }

    #[test]
    fn the_largest_gains_do_not_overflow() {
        let law = ControlLaw::new(ControlLaw::GAIN_MAX, ControlLaw::GAIN_MAX, 400);
        let ends = [FineCounts::from_raw(0), FineCounts::from_raw(1023 * 256 + 192)];
        for command in ends {
            for pressure in ends {
                for previous in ends {
                    let drive = law.drive(command, pressure, previous).get();
                    assert!((-400..=400).contains(&drive));
                }
            }
        }
    }
}
