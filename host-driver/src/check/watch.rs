use super::SelfTest;
use crate::Calibration;
use crate::poller::{BoardRow, BoardState, Event, Observer, Outcome, Row};
use pneudrive_protocol::{CHANNELS, Counts};
use std::time::Duration;

/// Collects readings, and breaks the test off where something is not as it should be.
pub(super) struct Watch {
    test: SelfTest,
    calibration: Calibration,
    /// When the board that is tested answered last, ns since the start.
    answered_ns: u64,
    /// How often it was asked in vain since then.
    in_vain: u32,
}

impl Watch {
    /// So long without an answer is no lost packet, ns; well before a board's own command timeout.
    const SILENT_NS: u64 = 300_000_000;
    /// As long a silence in which the board was asked less often is this machine's, unless the
    /// poller has given it up.
    const ASKED: u32 = 10;
    /// Above the highest level by this much, kPa: more than any loop overshoots. A valve that stays
    /// open goes on beyond it.
    const TOO_HIGH_KPA: f64 = 40.0;

    pub(super) fn new(test: SelfTest, calibration: Calibration) -> Self {
        Self { test, calibration, answered_ns: 0, in_vain: 0 }
    }

    /// What is wrong with a board that is tested; `highest_kpa` is what its channels may be
    /// commanded in the test.
    fn wrong(row: &BoardRow, highest_kpa: [f64; CHANNELS]) -> Option<String> {
        let reading = row.fresh()?;
        (0..CHANNELS).find_map(|channel| {
            let kpa = reading.kpa[channel];
            if [Counts::MIN, Counts::MAX].contains(&reading.counts[channel]) {
                Some(format!("channel {channel}: its sensor is broken or not connected"))
            } else if kpa > highest_kpa[channel] + Self::TOO_HIGH_KPA {
                Some(format!(
                    "channel {channel} was at {kpa:.0} kPa, far above the {:.0} kPa of the check",
                    highest_kpa[channel]
                ))
            } else {
                None
            }
        })
    }

    /// The board that is tested was sent 0 kPa in the midst of its plan: what it does from there on
    /// is not what was planned.
    fn paused(&self, boards: &[u8], unheard: Duration, host_late: Option<Duration>) {
        let number = self.test.begun();
        if !boards.contains(&self.test.plan(number).board) {
            return;
        }
        let why = format!(
            "the board was not heard for {:.2} s, and sent 0 kPa until it was",
            unheard.as_secs_f64()
        );
        match host_late {
            Some(_) => {
                self.test.abort(format!("{why}: this program was held up; try again on a quieter machine"))
            }
            None => self.test.fail(number, why),
        }
    }
}

impl Observer for Watch {
    fn row(&mut self, row: &Row<'_>) {
        let Some((number, t_s)) = self.test.at(row.since_start_ns as f64 * 1e-9) else { return };
        let plan = self.test.plan(number);
        let Some(board) = row.boards.get(plan.index) else { return };
        match board.fresh() {
            Some(reading) => {
                (self.answered_ns, self.in_vain) = (row.since_start_ns, 0);
                // The board was asked a little after the cycle began, later where others come
                // before it.
                let t_s = t_s + reading.asked_ns.saturating_sub(row.at_ns) as f64 * 1e-9;
                let command = self.calibration.command_kpa(plan.board, board.command);
                self.test.locked().tries[number].samples.push(t_s, command, reading.kpa);
            }
            None => {
                self.in_vain += u32::from(board.outcome == Outcome::Lost);
                let asked = self.in_vain >= Self::ASKED || board.state == BoardState::Missing;
                if asked && row.since_start_ns.saturating_sub(self.answered_ns) > Self::SILENT_NS {
                    self.test.fail(number, "the board does not answer".to_owned());
                }
            }
        }
        // A chamber may still be under pressure when its plan begins; by then it has had time to
        // vent.
        let seen = t_s > 0.1 * plan.plan.seconds();
        if let Some(why) = Self::wrong(board, plan.plan.levels_kpa()).filter(|_| seen) {
            self.test.fail(number, why);
        }
    }

    fn event(&mut self, event: &Event<'_>) {
        let why = match event {
            Event::LineLost { error, .. } => {
                return self.test.fail(self.test.begun(), format!("the port failed: {error}"));
            }
            Event::Vented => "somebody vented the boards".to_owned(),
            Event::Stalled { by } => {
                format!(
                    "this program stood still for {:.1} s; try again on a quieter machine",
                    by.as_secs_f64()
                )
            }
            Event::Paused { boards, unheard, host_late } => return self.paused(boards, *unheard, *host_late),
            _ => return,
        };
        self.test.abort(why);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BoardPlan, Plan};
    use super::*;

    /// The reports of boards 2 and 5 after a pause of `boards`, the first of them in the middle of
    /// its plan.
    fn after_pause(boards: &[u8], host_late: Option<Duration>) -> Vec<(Option<String>, bool)> {
        let plan = |(index, board)| BoardPlan { board, index, plan: Plan::new([150.0; 4], 1.0).unwrap() };
        let plans = [2, 5].into_iter().enumerate().map(plan).collect();
        let (test, _, mut watch) = SelfTest::new(plans, &Calibration::default());
        watch.event(&Event::Paused { boards, unheard: Duration::from_millis(450), host_late });
        assert_eq!(test.is_aborted(), boards.contains(&2));
        test.reports(None).into_iter().map(|report| (report.aborted, report.unjudged)).collect()
    }

    #[test]
    fn a_board_that_was_sent_0_kpa_in_its_plan_is_not_judged_by_what_came_after() {
        let told = |reports: &[(Option<String>, bool)]| reports[0].0.clone().unwrap_or_default();
        let own = after_pause(&[2], None);
        assert!(told(&own).contains("not heard for 0.45 s") && !own[0].1, "{own:?}");
        let held_up = after_pause(&[2], Some(Duration::from_millis(120)));
        assert!(told(&held_up).contains("a quieter machine") && held_up[0].1, "{held_up:?}");
        after_pause(&[5], None);
    }
}
