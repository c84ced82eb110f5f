use super::{Character, Heard, Line, Talker};
use std::collections::VecDeque;

/// Fights that can go on at the same time; more talkers at once than that are not told apart.
const FIGHTS_KEPT: usize = 16;

/// A character on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct InFlight {
    pub talker: Talker,
    pub start_ns: u64,
    pub end_ns: u64,
    pub heard: Heard,
    /// Its talker's rate.
    pub line: Line,
    /// Noise that fell into a character spoils that character; no receiver takes it for one of its
    /// own.
    pub absorbed: bool,
}

impl InFlight {
    pub fn of(talker: Talker, line: Line, start_ns: u64, heard: Heard) -> Self {
        Self { talker, start_ns, end_ns: start_ns + line.character_ns(), heard, line, absorbed: false }
    }
}

/// What a new character met on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contention {
    /// Nobody else spoke.
    None,
    /// Another party spoke, and these two runs of characters have not met before.
    Begun {
        /// The party that was there first.
        with: Talker,
    },
}

/// The pair of wires: who speaks, and what becomes of characters that overlap.
#[derive(Debug)]
pub(super) struct Wire {
    flights: Vec<InFlight>,
    /// Every talker's present or last run of characters.
    runs: Vec<Run>,
    runs_begun: u64,
    /// Pairs of runs that have met, as the newer run's number and the older one's; the latest few
    /// are enough.
    fights: VecDeque<(u64, u64)>,
}

/// Characters of one talker without a pause of more than a bit: a request, an answer.
#[derive(Debug, Clone, Copy)]
struct Run {
    talker: Talker,
    number: u64,
    end_ns: u64,
}

impl Wire {
    pub fn new() -> Self {
        Self {
            flights: Vec::with_capacity(8),
            runs: Vec::new(),
            runs_begun: 0,
            fights: VecDeque::with_capacity(FIGHTS_KEPT),
        }
    }

    /// Nothing is on its way.
    pub fn is_free(&self) -> bool {
        self.flights.is_empty()
    }

    /// End of the stop bit that ends next.
    pub fn next_end_ns(&self) -> Option<u64> {
        self.flights.iter().map(|flight| flight.end_ns).min()
    }

    /// A start bit falls. Two drivers pull the pair both ways: what overlaps is damaged on both
    /// sides, and as a zero usually wins, the bits are the AND of both. Noise is too weak to be
    /// seen as a fight: it flips bits, and only some of them in the stop bit.
    pub fn begin(&mut self, talker: Talker, line: Line, character: Character) -> Contention {
        let start_ns = character.start_ns;
        let heard = Heard { byte: character.byte, damaged: false };
        let mut new = InFlight::of(talker, line, start_ns, heard);
        let end_ns = new.end_ns;
        let run = self.run_of(talker, line.bit_ns(), (start_ns, end_ns));
        let mut fights_with = None;
        for other in &mut self.flights {
            let overlap = other.talker != talker && other.start_ns < end_ns && start_ns < other.end_ns;
            match (overlap, talker, other.talker) {
                (false, _, _) => {}
                (true, Talker::Noise, _) => spoil(other, &mut new),
                (true, _, Talker::Noise) => spoil(&mut new, other),
                (true, _, with) => {
                    let mixed = other.heard.byte & new.heard.byte;
                    other.heard = Heard { byte: mixed, damaged: true };
                    new.heard = Heard { byte: mixed, damaged: true };
                    fights_with = Some(with);
                }
            }
        }
        self.flights.push(new);
        match fights_with {
            Some(with) if self.first_meeting(run, with) => Contention::Begun { with },
            _ => Contention::None,
        }
    }

    /// Number of the run that a new character of `talker` belongs to.
    fn run_of(&mut self, talker: Talker, bit_ns: u64, (start_ns, end_ns): (u64, u64)) -> u64 {
        let place = self.runs.iter().position(|run| run.talker == talker).unwrap_or_else(|| {
            self.runs.push(Run { talker, number: 0, end_ns: 0 });
            self.runs.len() - 1
        });
        let run = &mut self.runs[place];
        if run.number == 0 || start_ns > run.end_ns + bit_ns {
            self.runs_begun += 1;
            run.number = self.runs_begun;
        }
        run.end_ns = end_ns;
        run.number
    }

    fn first_meeting(&mut self, run: u64, with: Talker) -> bool {
        let Some(other) = self.runs.iter().find(|run| run.talker == with).map(|run| run.number) else {
            return false;
        };
        let pair = (run.max(other), run.min(other));
        if self.fights.contains(&pair) {
            return false;
        }
        if self.fights.len() == FIGHTS_KEPT {
            self.fights.pop_front();
        }
        self.fights.push_back(pair);
        true
    }

    /// The driver let go before the stop bit of the character that `talker` began last: its
    /// receivers flag it.
    pub fn cut_off_last(&mut self, talker: Talker) {
        if let Some(flight) = self.flights.iter_mut().rev().find(|flight| flight.talker == talker) {
            flight.heard.damaged = true;
        }
    }

    /// The next character whose stop bit has ended by `now_ns`, in order of time.
    pub fn take_ended(&mut self, now_ns: u64) -> Option<InFlight> {
        let (index, flight) = self.flights.iter().enumerate().min_by_key(|(_, flight)| flight.end_ns)?;
        (flight.end_ns <= now_ns).then(|| self.flights.remove(index))
    }
}

/// Noise hits a character: at least one bit flips, and the highest bit decides whether the stop bit
/// is hit too.
fn spoil(character: &mut InFlight, noise: &mut InFlight) {
    character.heard.byte ^= noise.heard.byte | 1;
    character.heard.damaged |= noise.heard.byte >= 0x80;
    noise.absorbed = true;
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Baud;

    fn line() -> Line {
        Line::at_baud(Baud::ORIGINAL).unwrap()
    }

    fn at(start_ns: u64, byte: u8) -> Character {
        Character { start_ns, byte }
    }

    #[test]
    fn a_character_is_heard_one_character_after_its_start_bit() {
        let mut wire = Wire::new();
        wire.begin(Talker::Host, line(), at(5_000, 0xA5));
        assert_eq!(wire.next_end_ns(), Some(15_000));
        assert_eq!(wire.take_ended(14_999), None);
        assert_eq!(wire.take_ended(15_000).unwrap().heard, Heard { byte: 0xA5, damaged: false });
        assert!(wire.is_free());
    }

    #[test]
    fn back_to_back_is_no_overlap_but_one_nanosecond_is() {
        let mut wire = Wire::new();
        assert_eq!(wire.begin(Talker::Host, line(), at(0, 1)), Contention::None);
        assert_eq!(wire.begin(Talker::Board(0), line(), at(10_000, 2)), Contention::None);
        assert_eq!(
            wire.begin(Talker::Board(1), line(), at(19_999, 7)),
            Contention::Begun { with: Talker::Board(0) }
        );
        let heard: Vec<Heard> =
            std::iter::from_fn(|| wire.take_ended(100_000)).map(|flight| flight.heard).collect();
        let fought = Heard { byte: 2, damaged: true };
        assert_eq!(heard, [Heard { byte: 1, damaged: false }, fought, fought]);
    }

    #[test]
    fn two_packets_on_top_of_each_other_are_one_collision() {
        let mut wire = Wire::new();
        let mut begun = 0;
        for i in 0..10 {
            let first = wire.begin(Talker::Board(0), line(), at(i * 10_000, 0));
            let second = wire.begin(Talker::Board(1), line(), at(i * 10_000 + 3_000, 0));
            begun += [first, second].iter().filter(|c| matches!(c, Contention::Begun { .. })).count();
            while wire.take_ended(i * 10_000 + 10_000).is_some() {}
        }
        assert_eq!(begun, 1);
        // After a silence a new fight is a new collision.
        wire.begin(Talker::Board(0), line(), at(500_000, 0));
        assert!(matches!(wire.begin(Talker::Host, line(), at(500_001, 0)), Contention::Begun { .. }));
    }

    /// A host that does not wait for answers talks without end; every answer it talks into counts.
    #[test]
    fn each_answer_that_a_babbling_host_spoils_is_a_collision() {
        let mut wire = Wire::new();
        let mut begun = 0;
        for i in 0..60 {
            let host = wire.begin(Talker::Host, line(), at(i * 10_000, 0));
            // Answers of ten characters, ten characters apart.
            let board =
                (i / 10 % 2 == 1).then(|| wire.begin(Talker::Board(0), line(), at(i * 10_000 + 2_000, 0)));
            begun += [Some(host), board].iter().flatten().filter(|c| **c != Contention::None).count();
            while wire.take_ended(i * 10_000 + 10_000).is_some() {}
        }
        assert_eq!(begun, 3);
    }

    #[test]
    fn noise_flips_bits_and_is_not_heard_besides() {
        let mut wire = Wire::new();
        wire.begin(Talker::Host, line(), at(0, 0xF0));
        assert_eq!(wire.begin(Talker::Noise, line(), at(4_000, 0x13)), Contention::None);
        let first = wire.take_ended(50_000).unwrap();
        assert_eq!(first.heard, Heard { byte: 0xE3, damaged: false });
        assert!(wire.take_ended(50_000).unwrap().absorbed);
    }
}
