use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What happened on the bus, in numbers. Serialised, it is the JSON object that `pneudrive-sim`
/// prints at its end.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct BusCounters {
    /// Packets that the host put on the wire whole, to whatever address.
    pub requests: u64,
    /// Answers of ten characters that boards put on the wire (damaged on the way or not).
    pub answers: u64,
    /// Times that a talker began while another one spoke; every character that overlaps is damaged.
    pub collisions: u64,
    /// Answers begun before the request's last stop bit plus the least turnaround.
    pub early: u64,
    /// Answers with an eleventh character, or that outlast the 555's shortest pulse.
    pub overlong: u64,
    /// Pauses of more than a bit inside an answer.
    pub gaps: u64,
    /// Answers that ended before their tenth character.
    pub truncated: u64,
    /// Answers that nobody asked that board for, or that it gave twice.
    pub unasked: u64,
    /// Characters that the host put on the wire.
    pub host_characters: u64,
    /// Characters that boards put on the wire.
    pub board_characters: u64,
    /// Injected faults that took effect, by name.
    pub faults: BTreeMap<String, u64>,
}

impl BusCounters {
    /// Everything that a healthy bus never shows: collisions, early, overlong, gapped, truncated
    /// and unasked answers.
    pub fn violations(&self) -> u64 {
        self.collisions + self.early + self.overlong + self.gaps + self.truncated + self.unasked
    }

    /// Faults of this kind that took effect.
    pub fn fault(&self, name: &str) -> u64 {
        self.faults.get(name).copied().unwrap_or(0)
    }

    pub(crate) fn count_fault(&mut self, name: &'static str) {
        match self.faults.get_mut(name) {
            Some(count) => *count += 1,
            None => {
                self.faults.insert(name.to_owned(), 1);
            }
        }
    }
}
