use crate::BoardConfig;
use crate::sample::FineCounts;
use pneudrive_protocol::Counts;

/// Why a channel's sensor cannot be believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorFault {
    /// Below the sensor's range: broken signal wire, no supply, short circuit to ground.
    BelowRange,
    /// Above the sensor's range: broken ground wire, short circuit to the supply, overpressure.
    AboveRange,
}

impl SensorFault {
    /// What an answer carries in place of the channel's pressure: 0 or 1023 counts.
    ///
    /// The format has no room for a flag; but no healthy channel reports these two values, because
    /// they lie outside the limits that a pressure must be within to be believed. Hosts that know
    /// nothing of this see an impossible pressure.
    pub const fn reported(self) -> Counts {
        match self {
            Self::BelowRange => Counts::MIN,
            Self::AboveRange => Counts::MAX,
        }
    }
}

/// What to do with a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Use it.
    Good,
    /// Out of range, but not yet for long: ignore it.
    Suspect(SensorFault),
    /// The channel's sensor is faulty.
    Faulty(SensorFault),
}

/// Debounces one sensor's excursions out of its range, and its return.
#[derive(Debug, Clone)]
pub(crate) struct SensorMonitor {
    low: FineCounts,
    high: FineCounts,
    fault_after: u16,
    recover_after: u16,
    state: State,
}

#[derive(Debug, Clone, Copy)]
enum State {
    Healthy { bad_run: u16 },
    Faulty { fault: SensorFault, good_run: u16 },
}

impl SensorMonitor {
    pub(crate) fn new(config: &BoardConfig) -> Self {
        Self {
            low: FineCounts::from_counts(config.sensor_low()),
            high: FineCounts::from_counts(config.sensor_high()),
            fault_after: config.fault_after_steps,
            recover_after: config.recover_after_steps,
            state: State::Healthy { bad_run: 0 },
        }
    }

    pub(crate) fn judge(&mut self, sample: FineCounts) -> Verdict {
        let out_of_range = self.out_of_range(sample);
        self.state = match (self.state, out_of_range) {
            (State::Healthy { .. }, None) => State::Healthy { bad_run: 0 },
            (State::Healthy { bad_run }, Some(fault)) if bad_run + 1 >= self.fault_after => {
                State::Faulty { fault, good_run: 0 }
            }
            (State::Healthy { bad_run }, Some(_)) => State::Healthy { bad_run: bad_run + 1 },
            (State::Faulty { good_run, .. }, None) if good_run + 1 >= self.recover_after => {
                State::Healthy { bad_run: 0 }
            }
            (State::Faulty { fault, good_run }, None) => State::Faulty { fault, good_run: good_run + 1 },
            (State::Faulty { .. }, Some(fault)) => State::Faulty { fault, good_run: 0 },
        };
        match (self.state, out_of_range) {
            (State::Faulty { fault, .. }, _) => Verdict::Faulty(fault),
            (State::Healthy { .. }, Some(fault)) => Verdict::Suspect(fault),
            (State::Healthy { .. }, None) => Verdict::Good,
        }
    }

    fn out_of_range(&self, sample: FineCounts) -> Option<SensorFault> {
        if sample < self.low {
            Some(SensorFault::BelowRange)
        } else if sample > self.high {
            Some(SensorFault::AboveRange)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use SensorFault::{AboveRange, BelowRange};
    use Verdict::{Faulty, Good, Suspect};

    fn monitor() -> SensorMonitor {
        let config = BoardConfig { fault_after_steps: 3, recover_after_steps: 2, ..BoardConfig::default() };
        SensorMonitor::new(&config)
    }

    fn judge(monitor: &mut SensorMonitor, counts: u16) -> Verdict {
        monitor.judge(FineCounts::from_counts(Counts::new(counts).unwrap()))
    }

    #[test]
    fn the_limits_themselves_are_good() {
        let verdicts = [50, 51, 973, 974].map(|counts| judge(&mut monitor(), counts));
        assert_eq!(verdicts, [Suspect(BelowRange), Good, Good, Suspect(AboveRange)]);
    }

    #[test]
    fn a_fault_takes_a_run_of_bad_samples_and_so_does_its_end() {
        let mut monitor = monitor();
        let samples = [0, 0, 500, 0, 0, 0, 500, 0, 500, 500, 0];
        let verdicts = samples.map(|counts| judge(&mut monitor, counts));
        let (suspect, faulty) = (Suspect(BelowRange), Faulty(BelowRange));
        assert_eq!(
            verdicts,
            [suspect, suspect, Good, suspect, suspect, faulty, faulty, faulty, faulty, Good, suspect]
        );
    }

    #[test]
    fn a_fault_names_the_side_it_was_last_seen_on() {
        let mut monitor = monitor();
        let verdicts = [0, 0, 1023, 0, 500].map(|counts| judge(&mut monitor, counts));
        assert_eq!(verdicts[2..], [Faulty(AboveRange), Faulty(BelowRange), Faulty(BelowRange)]);
    }
}
