//! Settings of a poller.

use super::slew::{Slew, SlewOptions};
use super::{
    Limits, LineRatePolicy, Pace, PageShare, PresencePolicy, PressureFilter, ReopenPolicy, VentLatch,
};
use crate::Calibration;
use crate::real_time::RealTime;
use std::time::Duration;

/// Settings of a poller. Begin with [`for_devices`](Self::for_devices), and change what differs.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PollerOptions {
    /// Numbers of the boards, in the order in which they are asked.
    pub boards: Vec<u8>,
    /// How often.
    pub pace: Pace,
    /// What counts mean.
    pub calibration: Calibration,
    /// Low-pass on the pressures in [`Reading::kpa`](super::Reading::kpa); recordings hold what the
    /// boards sent.
    pub filter: Option<PressureFilter>,
    /// When a board counts as missing.
    pub presence: PresencePolicy,
    /// Whether to go on when the line has failed and comes back (an adapter that was unplugged);
    /// `None` ends the poller. While the line is gone its boards are missing, and vent by their own
    /// command timeout (those of the original kind have none).
    pub reopen: Option<ReopenPolicy>,
    /// What happens when the line is back: `false` closes [`vent`](Self::vent), so that the boards
    /// stay at 0 kPa until somebody releases them; `true` returns to the set points of that time,
    /// by a ramp.
    pub resume: bool,
    /// Closed by whoever wants all boards at 0 kPa.
    pub vent: VentLatch,
    /// Highest set points and fastest changes.
    pub limits: Limits,
    /// Fastest rise of a set point after a pause, kPa/s, until what is wanted has been reached. A
    /// pause is a vent, or a time without answers that is long enough for a board's own command
    /// timeout; the ramp starts at the pressure that the board reports.
    pub return_rate_kpa_s: f64,
    /// After which share of its polls a board is asked for its valves' drives as well; `None`, the
    /// default, for none. Each such request takes the bus as long as a poll.
    pub drives: Option<PageShare>,
    /// After which share of its polls a board is asked for a page of the sensors on its I2C
    /// connector as well; `None`, the default, for none. What it has is asked for in turn: the
    /// supply pressure takes a page, an IMU two.
    pub sensors: Option<PageShare>,
    /// Whether to ask the boards for a faster line rate; `None`, the default, is not.
    pub line_rate: Option<LineRatePolicy>,
    /// What the bus thread asks of the scheduler; nothing by default.
    pub real_time: RealTime,
}

impl PollerOptions {
    /// A chamber that is to return to 300 kPa does so in 3 s: slow enough to step back from, fast
    /// enough not to be waited for.
    pub const RETURN_RATE_KPA_S: f64 = 100.0;

    /// What a board's [`Slew`] is made of. `timeout_ns` is how long an answer is waited for: where
    /// boards are missing, a cycle takes as many of them, and is no pause of the others.
    pub(super) fn slew(&self, board: u8, timeout_ns: u64) -> Slew {
        let period = match self.pace {
            Pace::AsFastAsPossible => Duration::ZERO,
            Pace::Every { period, .. } => period,
        };
        let all_missing_ns = timeout_ns.saturating_mul(self.boards.len() as u64);
        let options = SlewOptions {
            scales: self.calibration.of(board),
            vent: self.calibration.vent(&self.boards),
            return_rate_kpa_s: self.return_rate_kpa_s,
            period: period.max(Duration::from_nanos(all_missing_ns)),
        };
        Slew::new(self.limits.of(board), options)
    }

    /// Boards 0 to `devices - 1`, as fast as possible, unfiltered; goes on when a lost line comes
    /// back.
    pub fn for_devices(devices: u16) -> Self {
        Self {
            boards: (0..=u8::MAX).take(usize::from(devices)).collect(),
            pace: Pace::default(),
            calibration: Calibration::default(),
            filter: None,
            presence: PresencePolicy::default(),
            reopen: Some(ReopenPolicy::default()),
            resume: false,
            vent: VentLatch::default(),
            limits: Limits::default(),
            return_rate_kpa_s: Self::RETURN_RATE_KPA_S,
            drives: None,
            sensors: None,
            line_rate: None,
            real_time: RealTime::default(),
        }
    }

    /// How often.
    #[must_use]
    pub fn pace(self, pace: Pace) -> Self {
        Self { pace, ..self }
    }

    /// What counts mean.
    #[must_use]
    pub fn calibration(self, calibration: impl Into<Calibration>) -> Self {
        Self { calibration: calibration.into(), ..self }
    }

    /// Low-pass on the pressures in [`Reading::kpa`](super::Reading::kpa).
    #[must_use]
    pub fn filter(self, filter: impl Into<Option<PressureFilter>>) -> Self {
        Self { filter: filter.into(), ..self }
    }

    /// Whether to go on when the line has failed and comes back.
    #[must_use]
    pub fn reopen(self, reopen: impl Into<Option<ReopenPolicy>>) -> Self {
        Self { reopen: reopen.into(), ..self }
    }

    /// Whether the set points return by themselves when the line is back.
    #[must_use]
    pub fn resume(self, resume: bool) -> Self {
        Self { resume, ..self }
    }

    /// Closed by whoever wants all boards at 0 kPa.
    #[must_use]
    pub fn vent(self, vent: VentLatch) -> Self {
        Self { vent, ..self }
    }

    /// Highest set points and fastest changes.
    #[must_use]
    pub fn limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// After which share of its polls a board is asked for its valves' drives.
    #[must_use]
    pub fn drives(self, drives: impl Into<Option<PageShare>>) -> Self {
        Self { drives: drives.into(), ..self }
    }

    /// After which share of its polls a board is asked for a page of its sensors.
    #[must_use]
    pub fn sensors(self, sensors: impl Into<Option<PageShare>>) -> Self {
        Self { sensors: sensors.into(), ..self }
    }

    /// Whether to ask the boards for a faster line rate.
    #[must_use]
    pub fn line_rate(self, line_rate: impl Into<Option<LineRatePolicy>>) -> Self {
        Self { line_rate: line_rate.into(), ..self }
    }

    /// What the bus thread asks of the scheduler.
    #[must_use]
    pub fn real_time(self, real_time: RealTime) -> Self {
        Self { real_time, ..self }
    }
}
