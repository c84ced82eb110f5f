//! Which way of waiting for an answer is the fastest on this machine, found by trying.

/// A way of waiting for an answer, the cheapest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WaitStrategy {
    /// The kernel wakes the thread.
    Sleep,
    /// The thread sleeps until shortly before the answer is due, and looks from then on.
    BusyPollWhenDue,
    /// The thread looks from the request on. It keeps its core awake, which on a virtual machine or
    /// with a deep idle state saves more than a wake-up: the kernel's own threads, which carry a
    /// pty's or an adapter's bytes, start sooner too.
    BusyPoll,
}

/// The ways, tried in turn on the first answers, and shortly again from time to time: one trial can
/// fall into another program's busy second.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// How long answers took, ns, by way.
    delays_ns: [Vec<u64>; 3],
    /// Turns of each way in the trial that goes on or comes next.
    turns: usize,
    chosen: Option<WaitStrategy>,
    /// Answers since it was chosen.
    answers: usize,
}

impl Default for Trial {
    fn default() -> Self {
        Self { delays_ns: [const { Vec::new() }; 3], turns: Self::TURNS, chosen: None, answers: 0 }
    }
}

impl Trial {
    /// Answers to a turn, of which the second half counts: how soon cores wake up follows from how
    /// long they slept lately.
    const TURN: usize = 512;
    /// Turns of each way; their order takes slow changes of the machine out of the comparison.
    const TURNS: usize = 2;
    /// A choice holds for so many answers, 15 s of a busy bus; trying the three ways again takes
    /// 1536 more, one turn of each.
    const HOLDS: usize = 64 * 1024;
    /// What a dearer way has to save to be chosen: less is within what one trial and the next
    /// differ by.
    const WORTHWHILE: f64 = 0.01;
    const WAYS: [WaitStrategy; 3] =
        [WaitStrategy::Sleep, WaitStrategy::BusyPollWhenDue, WaitStrategy::BusyPoll];

    /// How to wait for the next answer.
    pub(super) fn way(&self) -> WaitStrategy {
        self.chosen.unwrap_or_else(|| Self::WAYS[self.turn()])
    }

    fn turn(&self) -> usize {
        let seen: usize = self.delays_ns.iter().map(Vec::len).sum();
        seen / Self::TURN % Self::WAYS.len()
    }

    /// An answer was complete so long after its request, ns.
    pub(super) fn seen(&mut self, delay_ns: u64) {
        if self.chosen.is_some() {
            self.answers += 1;
            if self.answers < Self::HOLDS {
                return;
            }
            // Room for the turn of each way, so that nothing is allocated while it lasts.
            *self = Self {
                delays_ns: [(); 3].map(|()| Vec::with_capacity(Self::TURN)),
                turns: 1,
                ..Self::default()
            };
            return;
        }
        let turn = self.turn();
        self.delays_ns[turn].push(delay_ns);
        if self.delays_ns.iter().all(|delays| delays.len() == Self::TURN * self.turns) {
            let usual = std::mem::take(&mut self.delays_ns).map(usual_delay);
            self.chosen = Some(Self::best(usual));
            log::debug!(
                "answers by way of waiting, us: {:?}; chosen: {:?}",
                usual.map(|ns| ns / 1e3),
                self.chosen
            );
        }
    }

    fn best(usual_ns: [f64; 3]) -> WaitStrategy {
        let mut best = 0;
        for dearer in 1..usual_ns.len() {
            if usual_ns[dearer] < (1.0 - Self::WORTHWHILE) * usual_ns[best] {
                best = dearer;
            }
        }
        Self::WAYS[best]
    }
}

/// Half of the answers that count came sooner.
#[expect(clippy::cast_precision_loss, reason = "nanoseconds of an exchange, far below 2^53")]
fn usual_delay(delays_ns: Vec<u64>) -> f64 {
    let settled = delays_ns.into_iter().enumerate().filter(|(n, _)| n % Trial::TURN >= Trial::TURN / 2);
    let mut delays_ns: Vec<u64> = settled.map(|(_, ns)| ns).collect();
    delays_ns.sort_unstable();
    delays_ns[delays_ns.len() / 2] as f64
}

#[cfg(test)]
mod tests {
    use super::{Trial, WaitStrategy};

    /// What a trial chooses on a machine where answers take so long, ns, by way, and every tenth
    /// ten times as long.
    fn choice(delay_ns: [u64; 3]) -> (Option<WaitStrategy>, usize) {
        let mut trial = Trial::default();
        let mut answers = 0;
        while trial.chosen.is_none() && answers < 10_000 {
            let ns = delay_ns[trial.way() as usize];
            trial.seen(if answers % 10 == 0 { 10 * ns } else { ns });
            answers += 1;
        }
        (trial.chosen, answers)
    }

    #[test]
    fn the_way_with_the_soonest_answers_is_kept() {
        assert_eq!(choice([250_000, 240_000, 228_000]).0, Some(WaitStrategy::BusyPoll));
        assert_eq!(choice([250_000, 228_000, 229_000]).0, Some(WaitStrategy::BusyPollWhenDue));
        assert_eq!(choice([228_000, 230_000, 260_000]).0, Some(WaitStrategy::Sleep));
    }

    #[test]
    fn the_first_answers_of_a_turn_do_not_count() {
        let mut trial = Trial::default();
        let mut of_this_turn = (trial.way(), 0);
        while trial.chosen.is_none() {
            let way = trial.way();
            of_this_turn = if of_this_turn.0 == way { (way, of_this_turn.1 + 1) } else { (way, 0) };
            // Looking is slow at first, and the fastest once the cores are awake.
            let looking = if of_this_turn.1 < 200 { 300_000 } else { 226_000 };
            trial.seen(if way == WaitStrategy::BusyPoll { looking } else { 245_000 });
        }
        assert_eq!(trial.chosen, Some(WaitStrategy::BusyPoll));
    }

    #[test]
    fn a_core_is_not_spent_on_less_than_one_percent() {
        assert_eq!(choice([229_000, 228_000, 227_000]).0, Some(WaitStrategy::Sleep));
    }

    #[test]
    fn a_choice_made_in_a_busy_second_is_made_again() {
        let mut trial = Trial::default();
        let chosen = |answers: usize, busy: bool, trial: &mut Trial| {
            for _ in 0..answers {
                let looking = if busy { 300_000 } else { 226_000 };
                trial.seen(if trial.way() == WaitStrategy::BusyPoll { looking } else { 245_000 });
            }
            trial.way()
        };
        assert_eq!(chosen(3200, true, &mut trial), WaitStrategy::Sleep);
        assert_eq!(chosen(Trial::HOLDS + 1600, false, &mut trial), WaitStrategy::BusyPoll);
    }

    #[test]
    fn it_is_over_within_3100_answers() {
        let (_, answers) = choice([250_000, 240_000, 228_000]);
        assert!(answers <= 3100, "{answers}");
    }
}
