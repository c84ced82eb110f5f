use super::{Character, Heard, Line, Talker};

/// A character on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct InFlight {
    pub talker: Talker,
    pub start_ns: u64,
    pub end_ns: u64,
    pub heard: Heard,
    /// Noise that fell into a character spoils that character; no receiver takes it for one of its own.
    pub absorbed: bool,
}

/// What a new character met on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contention {
    /// Nobody else spoke.
    None,
    /// Another party spoke, for the first time since the wire was last free.
    Begun {
        /// The party that was there first.
        with: Talker,
    },
    /// The fight goes on.
    Continued,
}

/// The pair of wires: who speaks, and what becomes of characters that overlap.
#[derive(Debug)]
pub(super) struct Wire {
    line: Line,
    flights: Vec<InFlight>,
    contended: bool,
    free_at_ns: u64,
}

impl Wire {
    pub fn new(line: Line) -> Self {
        Self { line, flights: Vec::with_capacity(8), contended: false, free_at_ns: 0 }
    }

    /// Nothing is on its way.
    pub fn is_free(&self) -> bool {
        self.flights.is_empty()
    }

    /// End of the stop bit that ends next.
    pub fn next_end_ns(&self) -> Option<u64> {
        self.flights.iter().map(|flight| flight.end_ns).min()
    }

    /// A start bit falls. Two drivers pull the pair both ways: what overlaps is damaged on both sides, and as a zero
    /// usually wins, the bits are the AND of both. Noise is too weak to be seen as a fight: it flips bits, and only
    /// some of them in the stop bit.
    pub fn begin(&mut self, talker: Talker, character: Character) -> Contention {
        let start_ns = character.start_ns;
        let end_ns = start_ns + self.line.character_ns();
        let mut new = InFlight {
            talker,
            start_ns,
            end_ns,
            heard: Heard { byte: character.byte, damaged: false },
            absorbed: false,
        };
        if start_ns > self.free_at_ns + self.line.bit_ns() {
            self.contended = false;
        }
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
        self.free_at_ns = self.free_at_ns.max(end_ns);
        match fights_with {
            None => Contention::None,
            Some(_) if self.contended => Contention::Continued,
            Some(with) => {
                self.contended = true;
                Contention::Begun { with }
            }
        }
    }

    /// The driver let go before the stop bit of the character that `talker` began last: its receivers flag it.
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

/// Noise hits a character: at least one bit flips, and the highest bit decides whether the stop bit is hit too.
fn spoil(character: &mut InFlight, noise: &mut InFlight) {
    character.heard.byte ^= noise.heard.byte | 1;
    character.heard.damaged |= noise.heard.byte >= 0x80;
    noise.absorbed = true;
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Baud;

    fn wire() -> Wire {
        Wire::new(Line::at_baud(Baud::ORIGINAL).unwrap())
    }

    fn at(start_ns: u64, byte: u8) -> Character {
        Character { start_ns, byte }
    }

    #[test]
    fn a_character_is_heard_one_character_after_its_start_bit() {
        let mut wire = wire();
        wire.begin(Talker::Host, at(5_000, 0xA5));
        assert_eq!(wire.next_end_ns(), Some(15_000));
        assert_eq!(wire.take_ended(14_999), None);
        assert_eq!(wire.take_ended(15_000).unwrap().heard, Heard { byte: 0xA5, damaged: false });
        assert!(wire.is_free());
    }

    #[test]
    fn back_to_back_is_no_overlap_but_one_nanosecond_is() {
        let mut wire = wire();
        assert_eq!(wire.begin(Talker::Host, at(0, 1)), Contention::None);
        assert_eq!(wire.begin(Talker::Board(0), at(10_000, 2)), Contention::None);
        assert_eq!(wire.begin(Talker::Board(1), at(19_999, 7)), Contention::Begun { with: Talker::Board(0) });
        let heard: Vec<Heard> =
            std::iter::from_fn(|| wire.take_ended(100_000)).map(|flight| flight.heard).collect();
        let fought = Heard { byte: 2, damaged: true };
        assert_eq!(heard, [Heard { byte: 1, damaged: false }, fought, fought]);
    }

    #[test]
    fn two_packets_on_top_of_each_other_are_one_collision() {
        let mut wire = wire();
        let mut begun = 0;
        for i in 0..10 {
            let first = wire.begin(Talker::Board(0), at(i * 10_000, 0));
            let second = wire.begin(Talker::Board(1), at(i * 10_000 + 3_000, 0));
            begun += [first, second].iter().filter(|c| matches!(c, Contention::Begun { .. })).count();
            while wire.take_ended(i * 10_000 + 10_000).is_some() {}
        }
        assert_eq!(begun, 1);
        // After a silence a new fight is a new collision.
        wire.begin(Talker::Board(0), at(500_000, 0));
        assert!(matches!(wire.begin(Talker::Host, at(500_001, 0)), Contention::Begun { .. }));
    }

    #[test]
    fn noise_flips_bits_and_is_not_heard_besides() {
        let mut wire = wire();
        wire.begin(Talker::Host, at(0, 0xF0));
        assert_eq!(wire.begin(Talker::Noise, at(4_000, 0x13)), Contention::None);
        let first = wire.take_ended(50_000).unwrap();
        assert_eq!(first.heard, Heard { byte: 0xE3, damaged: false });
        assert!(wire.take_ended(50_000).unwrap().absorbed);
    }
}
