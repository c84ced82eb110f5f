//! `[controller]`: the pressure loop that runs on the board, in 10-bit counts.

use super::RigError;
use super::check::Checker;
pub use crate::board::Controller;

impl Controller {
    pub(super) fn check(&self, checker: &Checker<'_>) -> Result<(), RigError> {
        checker.within(
            "controller.rate_hz",
            self.rate_hz,
            (1.0, 100_000.0),
            "Hz",
            "it is the rate of the board's loop",
        )?;
        checker.within(
            "controller.kp",
            self.kp,
            (1e-6, 1e6),
            "drive counts per pressure count",
            "a loop without proportional gain does not follow its command",
        )?;
        checker.within(
            "controller.kd",
            self.kd,
            (0.0, 1e6),
            "drive counts per count",
            "leave it out for none",
        )?;
        checker.within(
            "controller.saturation",
            self.saturation,
            (1e-6, 1e6),
            "drive counts",
            "it is the drive at which the valve is fully open",
        )?;
        checker.within(
            "controller.filter",
            self.filter,
            (0.0, 0.9999),
            "",
            "it is the weight of the previous sample: 0 for no filter, 1 would never follow",
        )
    }
}
