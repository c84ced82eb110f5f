//! A self-test on a bus: what [`pneudrive_check`] plans and measures, with the boards of a poller.
//!
//! One board after the other goes through its plan while all others are at 0 kPa. Anything that is
//! not as it should be ends it: the source of commands then ends, and the poller commands 0 kPa
//! until all boards have confirmed it.
//!
//! A board whose values depend on rows that came late, because the machine was busy, goes through
//! its plan again at the end.

mod source;
mod watch;

pub use pneudrive_check::{
    BoardReport, Measured, Missing, Plan, PlanError, Quantity, Report, Samples, Value, Verdict, completed,
    judge, measure, page, problems, table,
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

/// Times that a board goes through its plan at the most.
const MOST_TRIES: usize = 3;

#[derive(Debug, Default)]
struct Shared {
    /// What has been begun, one after the other.
    tries: Vec<Try>,
    /// Why it was broken off.
    aborted: Option<Aborted>,
}

/// Why a test was broken off.
#[derive(Debug, Clone)]
struct Aborted {
    /// In which try.
    number: usize,
    why: String,
    /// Whether the board, or the line to it, is the reason.
    failed: bool,
}

/// A plan that a board goes through once.
#[derive(Debug, Clone, Default)]
struct Try {
    /// Which plan.
    place: usize,
    samples: Samples,
}

impl SelfTest {
    /// The test, what commands it and what listens to it: the latter two are for the poller.
    /// `calibration` is the poller's.
    pub fn new(
        plans: Vec<BoardPlan>,
        calibration: &Calibration,
    ) -> (Self, Box<dyn CommandSource>, Box<dyn Observer>) {
        let first = |place| Try { place, samples: Samples::default() };
        let shared = Shared { tries: (0..plans.len()).map(first).collect(), aborted: None };
        let test = Self { shared: Arc::new(Mutex::new(shared)), plans: plans.into() };
        let source = Source::new(test.clone(), calibration.clone());
        let watch = Watch::new(test.clone(), calibration.clone());
        (test, Box::new(source), Box::new(watch))
    }

    /// How long it takes, s, if nothing has to be tried again.
    pub fn seconds(&self) -> f64 {
        self.plans.iter().map(|plan| plan.plan.seconds()).sum()
    }

    /// Breaks it off for a reason that is not the boards': 0 kPa is commanded and the poller ends.
    /// The first reason counts.
    pub fn abort(&self, why: impl Into<String>) {
        self.break_off(Aborted { number: self.begun(), why: why.into(), failed: false });
    }

    /// What was found, board by board; `earlier` is compared with. A board that was not done says
    /// why.
    pub fn reports(&self, earlier: Option<&Report>) -> Vec<BoardReport> {
        let shared = self.locked();
        let report = |(place, BoardPlan { board, plan, .. }): (usize, &BoardPlan)| match &shared.aborted {
            Some(Aborted { number, why, failed }) if place == shared.tries[*number].place => match failed {
                true => BoardReport::aborted(*board, why.clone()),
                false => BoardReport::unjudged(*board, why.clone()),
            },
            // Each plan's first try has its number.
            Some(Aborted { number, failed, .. }) if place > *number => BoardReport::unjudged(
                *board,
                if *failed { "not done: an earlier board ended the check" } else { "not done" },
            ),
            _ => {
                let before = earlier.and_then(|report| report.board(*board));
                judge(*board, shared.measured(place, plan), before)
            }
        };
        self.plans.iter().enumerate().map(report).collect()
    }

    /// Which try it is at `t_s`, and the time within it, s; `None` after the end. When all have
    /// ended, what was disturbed is tried again.
    fn at(&self, t_s: f64) -> Option<(usize, f64)> {
        let mut shared = self.locked();
        let mut begin_s = 0.0;
        for (number, one) in shared.tries.iter().enumerate() {
            let seconds = self.plans[one.place].plan.seconds();
            if t_s < begin_s + seconds {
                return Some((number, t_s - begin_s));
            }
            begin_s += seconds;
        }
        let again =
            (0..self.plans.len()).find(|&place| shared.is_worth_another(place, &self.plans[place].plan));
        let place = again.filter(|_| shared.aborted.is_none())?;
        shared.tries.push(Try { place, samples: Samples::default() });
        Some((shared.tries.len() - 1, t_s - begin_s))
    }

    /// The plan of a try.
    fn plan(&self, number: usize) -> &BoardPlan {
        &self.plans[self.locked().tries[number].place]
    }

    /// Breaks it off because of the board of a try, or of the line to it.
    fn fail(&self, number: usize, why: String) {
        self.break_off(Aborted { number, why, failed: true });
    }

    fn break_off(&self, aborted: Aborted) {
        self.locked().aborted.get_or_insert(aborted);
    }

    /// The last try that has been begun.
    fn begun(&self) -> usize {
        self.locked().tries.iter().rposition(|one| !one.samples.is_empty()).unwrap_or(0)
    }

    fn is_aborted(&self) -> bool {
        self.locked().aborted.is_some()
    }

    /// The bus thread and whoever asks for reports at the end: nobody waits.
    fn locked(&self) -> std::sync::MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shared {
    /// What all tries of a plan found together.
    fn measured(&self, place: usize, plan: &Plan) -> Vec<Measured> {
        let tries = self.tries.iter().filter(|one| one.place == place);
        tries.map(|one| measure(plan, &one.samples)).reduce(completed).unwrap_or_default()
    }

    fn is_worth_another(&self, place: usize, plan: &Plan) -> bool {
        let tries = self.tries.iter().filter(|one| one.place == place).count();
        tries < MOST_TRIES && self.measured(place, plan).iter().any(Measured::was_disturbed)
    }
}
