use crate::filter::LowPass;
use crate::law::ControlLaw;
use crate::sample::FineCounts;
use crate::sensor::{SensorMonitor, Verdict};
use crate::{AdcSample, BoardConfig, ChannelStatus, SensorFault, ValveDrive};
use pneudrive_protocol::Counts;

/// What the board as a whole wants of its channels in this step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    Regulate,
    Vent,
}

/// One valve, its chamber's sensor, and the loop between them.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    enabled: bool,
    monitor: SensorMonitor,
    filter: LowPass,
    law: ControlLaw,
    /// Filtered pressure of the last step, if there is one that can be believed.
    pressure: Option<FineCounts>,
    reported: Counts,
    status: ChannelStatus,
}

impl Channel {
    pub(crate) fn new(config: &BoardConfig, enabled: bool) -> Self {
        Self {
            enabled,
            monitor: SensorMonitor::new(config),
            filter: LowPass::new(config.filter_previous),
            law: ControlLaw::new(config.kp, config.kd, config.saturation),
            pressure: None,
            reported: Counts::MIN,
            status: ChannelStatus::Venting,
        }
    }

    /// One control step.
    pub(crate) fn step(&mut self, sample: AdcSample, command: Counts, mode: Mode) -> ValveDrive {
        if !self.enabled {
            self.reported = self.filter.step(sample.fine()).rounded();
            self.status = ChannelStatus::Disabled;
            return ValveDrive::FULL_VENT;
        }
        let previous = self.pressure;
        match (self.monitor.judge(sample.fine()), previous) {
            (Verdict::Good, _) => {
                let pressure = self.filter.step(sample.fine());
                self.pressure = Some(pressure);
                self.reported = pressure.rounded();
                self.regulate(command, pressure, previous.unwrap_or(pressure), mode)
            }
            // A glitch: neither the filter nor the damping term sees it.
            (Verdict::Suspect(_), Some(last_good)) => self.regulate(command, last_good, last_good, mode),
            // Out of range from the start: there is no pressure to go on with.
            (Verdict::Suspect(fault), None) | (Verdict::Faulty(fault), _) => self.vent_for(fault),
        }
    }

    fn regulate(
        &mut self,
        command: Counts,
        pressure: FineCounts,
        previous: FineCounts,
        mode: Mode,
    ) -> ValveDrive {
        match mode {
            Mode::Regulate => {
                self.status = ChannelStatus::Regulating;
                self.law.drive(FineCounts::from_counts(command), pressure, previous)
            }
            Mode::Vent => {
                self.status = ChannelStatus::Venting;
                ValveDrive::FULL_VENT
            }
        }
    }

    fn vent_for(&mut self, fault: SensorFault) -> ValveDrive {
        self.filter.reset();
        self.pressure = None;
        self.reported = fault.reported();
        self.status = ChannelStatus::SensorFault(fault);
        ValveDrive::FULL_VENT
    }

    /// What an answer carries for this channel.
    pub(crate) fn reported(&self) -> Counts {
        self.reported
    }

    pub(crate) fn status(&self) -> ChannelStatus {
        self.status
    }
}
