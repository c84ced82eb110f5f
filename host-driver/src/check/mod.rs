//! A self-test on a bus: what [`pneudrive_check`] plans and measures, with the boards of a poller.
//!
//! One board after the other goes through its plan while all others are at 0 kPa. Anything that is not as it should be ends it: the
//! source of commands then ends, and the poller commands 0 kPa until all boards have confirmed it.

mod source;
mod watch;

pub use pneudrive_check::{
    BoardReport, Measured, Plan, PlanError, Quantity, Report, Samples, Value, Verdict, judge, measure, page,
    problems, table,
};

use crate::Calibration;
use crate::poller::{CommandSource, Observer};
use source::Source;
use std::sync::{Arc, Mutex, PoisonError};
use watch::Watch;

/// A board and its plan.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardPlan {
    /// The board's number.
    pub board: u8,
    /// Its index among the boards that are polled.
    pub index: usize,
    /// What it goes through.
    pub plan: Plan,
}

/// A self-test of some boards, in progress.
#[derive(Debug, Clone)]
pub struct SelfTest {
    shared: Arc<Mutex<Shared>>,
    plans: Arc<[BoardPlan]>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Of each plan.
    samples: Vec<Samples>,
    /// Why it was broken off, and in which plan.
    aborted: Option<(usize, String)>,
}

impl SelfTest {
    /// The test, what commands it and what listens to it: the latter two are for the poller. `calibration` is the poller's.
    pub fn new(
        plans: Vec<BoardPlan>,
        calibration: &Calibration,
    ) -> (Self, Box<dyn CommandSource>, Box<dyn Observer>) {
        let shared = Shared { samples: vec![Samples::default(); plans.len()], aborted: None };
        let test = Self { shared: Arc::new(Mutex::new(shared)), plans: plans.into() };
        let source = Source::new(test.clone(), calibration.clone());
        let watch = Watch::new(test.clone(), calibration.clone());
        (test, Box::new(source), Box::new(watch))
    }

    /// How long it takes, s.
    pub fn seconds(&self) -> f64 {
        self.plans.iter().map(|plan| plan.plan.seconds()).sum()
    }

    /// Breaks it off: 0 kPa is commanded and the poller ends. The first reason counts.
    pub fn abort(&self, why: impl Into<String>) {
        let plan = self.plans.len().saturating_sub(1);
        self.abort_in(plan, why.into());
    }

    /// What was found, board by board; `earlier` is compared with. A board that was not done says why.
    pub fn reports(&self, earlier: Option<&Report>) -> Vec<BoardReport> {
        let shared = self.locked();
        let report = |(place, BoardPlan { board, plan, .. }): (usize, &BoardPlan)| match &shared.aborted {
            Some((at, why)) if place == *at => BoardReport::aborted(*board, why.clone()),
            Some((at, _)) if place > *at => {
                BoardReport::aborted(*board, "not done: an earlier board ended the check")
            }
            _ => {
                let before = earlier.and_then(|report| report.board(*board));
                judge(*board, measure(plan, &shared.samples[place]), before)
            }
        };
        self.plans.iter().enumerate().map(report).collect()
    }

    /// Which plan it is at `t_s`, and the time within it, s; `None` after the end.
    fn at(&self, t_s: f64) -> Option<(usize, f64)> {
        let mut begin_s = 0.0;
        for (place, plan) in self.plans.iter().enumerate() {
            let seconds = plan.plan.seconds();
            if t_s < begin_s + seconds {
                return Some((place, t_s - begin_s));
            }
            begin_s += seconds;
        }
        None
    }

    fn abort_in(&self, plan: usize, why: String) {
        self.locked().aborted.get_or_insert((plan, why));
    }

    fn is_aborted(&self) -> bool {
        self.locked().aborted.is_some()
    }

    /// The bus thread and whoever asks for reports at the end: nobody waits.
    fn locked(&self) -> std::sync::MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
