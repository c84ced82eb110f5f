use super::SelfTest;
use crate::Calibration;
use crate::poller::{BoardCommand, CommandSource, SourceStatus, VENTED};
use pneudrive_protocol::Counts;

/// The plans' set points.
pub(super) struct Source {
    test: SelfTest,
    calibration: Calibration,
}

impl Source {
    pub(super) fn new(test: SelfTest, calibration: Calibration) -> Self {
        Self { test, calibration }
    }
}

impl CommandSource for Source {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        commands.fill(VENTED);
        if self.test.is_aborted() {
            return SourceStatus::Ended;
        }
        let Some((number, t_s)) = self.test.at(since_start_ns as f64 * 1e-9) else {
            return SourceStatus::Ended;
        };
        let plan = self.test.plan(number);
        let Some(command) = commands.get_mut(plan.index) else { return SourceStatus::Continues };
        let kpa = plan.plan.command_kpa(t_s, &self.test.locked().tries[number].samples);
        for (channel, counts) in command.iter_mut().enumerate() {
            if kpa[channel] > 0.0 {
                let scale = self.calibration.channel(plan.board, channel);
                // Levels are below full scale; one that is not is not commanded.
                *counts = scale.counts(kpa[channel]).unwrap_or(Counts::ATMOSPHERE);
            }
        }
        SourceStatus::Continues
    }
}
