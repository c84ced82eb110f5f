use super::{FaultKind, FaultSpec, LineEvent, When};
use crate::bus::{Character, Line, Talker};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A fault of the pair or of a board: nothing, an episode, nothing, and so on.
#[derive(Debug)]
pub(super) struct EpisodeFault {
    spec: FaultSpec,
    rng: ChaCha8Rng,
    line: Line,
    boards: usize,
    begins_ns: Option<u64>,
    running: Option<Episode>,
}

#[derive(Debug, Clone, Copy)]
struct Episode {
    board: usize,
    ends_ns: u64,
    next_character_ns: Option<u64>,
}

/// What an episode's beginning or end means to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Turn {
    pub begins: bool,
    /// `None` for noise, which is nothing but its characters.
    pub event: Option<LineEvent>,
}

impl EpisodeFault {
    pub fn new(spec: FaultSpec, rng: ChaCha8Rng, line: Line, boards: usize) -> Self {
        let mut fault = Self { spec, rng, line, boards, begins_ns: None, running: None };
        fault.begins_ns = match fault.spec.when {
            When::At { time_ns } => Some(time_ns),
            When::Rate(_) => fault.draw_pause_ns(),
        };
        fault
    }

    pub fn name(&self) -> &'static str {
        self.spec.kind.name()
    }

    pub fn next_event_ns(&self) -> Option<u64> {
        match self.running {
            Some(episode) => {
                Some(episode.next_character_ns.map_or(episode.ends_ns, |at| at.min(episode.ends_ns)))
            }
            None => self.begins_ns,
        }
    }

    /// Begins or ends an episode that is due.
    pub fn turn(&mut self, now_ns: u64) -> Option<Turn> {
        match self.running {
            // What falls on the end still belongs to the episode.
            Some(episode) if episode.ends_ns <= now_ns && !self.character_due(now_ns) => {
                self.running = None;
                self.begins_ns = match self.spec.when {
                    When::At { .. } => None,
                    When::Rate(_) => self.draw_pause_ns().map(|pause| episode.ends_ns + pause),
                };
                Some(Turn { begins: false, event: self.line_event(episode.board, false) })
            }
            None => {
                let begins_ns = self.begins_ns.filter(|&at| at <= now_ns)?;
                let board = self.spec.board.unwrap_or_else(|| self.rng.random_range(0..self.boards.max(1)));
                let sends = matches!(self.spec.kind, FaultKind::Noise | FaultKind::Stray | FaultKind::Babble);
                let ends_ns = begins_ns + self.spec.duration_ns;
                self.running =
                    Some(Episode { board, ends_ns, next_character_ns: sends.then_some(begins_ns) });
                Some(Turn { begins: true, event: self.line_event(board, true) })
            }
            Some(_) => None,
        }
    }

    /// The next character of noise or babble whose start bit has fallen.
    pub fn character(&mut self, now_ns: u64) -> Option<(Talker, Character)> {
        if !self.character_due(now_ns) {
            return None;
        }
        let byte = self.rng.random();
        let (talker, pause_ns) = match self.spec.kind {
            FaultKind::Babble => (Talker::Board(self.running?.board), 0),
            // On average every second character time of a burst has one.
            _ => (Talker::Noise, self.rng.random_range(0..2 * self.line.character_ns())),
        };
        let single = self.spec.kind == FaultKind::Stray;
        let next_ns = self.running?.next_character_ns? + self.line.character_ns() + pause_ns;
        let episode = self.running.as_mut()?;
        let start_ns = episode.next_character_ns?;
        episode.next_character_ns = (!single && next_ns < episode.ends_ns).then_some(next_ns);
        Some((talker, Character { start_ns, byte }))
    }

    fn character_due(&self, now_ns: u64) -> bool {
        self.running.and_then(|episode| episode.next_character_ns).is_some_and(|at| at <= now_ns)
    }

    /// Time to the next episode: exponentially distributed, so that episodes come at random at the
    /// given rate.
    fn draw_pause_ns(&mut self) -> Option<u64> {
        let When::Rate(rate) = self.spec.when else { return None };
        let uniform: f64 = self.rng.random();
        (rate > 0.0).then(|| (-(1.0 - uniform).ln() / rate * 1e9) as u64)
    }

    fn line_event(&self, board: usize, begins: bool) -> Option<LineEvent> {
        Some(match (self.spec.kind, begins) {
            (FaultKind::Unplug, true) => LineEvent::Unplugged { board },
            (FaultKind::Unplug, false) => LineEvent::Replugged { board },
            (FaultKind::Babble, true) => LineEvent::BabbleBegins { board },
            (FaultKind::Babble, false) => LineEvent::BabbleEnds { board },
            (FaultKind::PowerCycle, true) => LineEvent::PowerOff { board },
            (FaultKind::PowerCycle, false) => LineEvent::PowerOn { board },
            _ => return None,
        })
    }
}
