//! Set points from the keyboard: only on a board that was armed, and by a ramp.

use pneudrive_protocol::CHANNELS;
use std::collections::BTreeMap;

/// A channel: the board's place in the poller's order, and the channel.
pub type Place = (usize, usize);

/// What the keyboard wants, and how far it has come.
#[derive(Debug, Default)]
pub struct Jog {
    /// The armed board, and when it was used last, ns.
    armed: Option<(usize, u64)>,
    /// Where channels are to go, and where their set points are, kPa.
    ways: BTreeMap<Place, Way>,
    stepped_ns: u64,
}

#[derive(Debug, Clone, Copy)]
struct Way {
    at_kpa: f64,
    to_kpa: f64,
}

impl Jog {
    /// Fastest change of a set point, kPa/s: that of the return after a pause.
    const RATE_KPA_S: f64 = 100.0;
    /// Without use a board is disarmed after this time, ns.
    const IDLE_NS: u64 = 60_000_000_000;
    /// The most time that one step makes up for, ns.
    const LONGEST_STEP_NS: u64 = 100_000_000;

    /// Arms a board, and disarms the others.
    pub fn arm(&mut self, board: usize, now_ns: u64) {
        self.disarm();
        self.armed = Some((board, now_ns));
    }

    /// Keys set nothing any more; what is on its way stays where it is.
    pub fn disarm(&mut self) {
        self.armed = None;
        self.ways.clear();
    }

    /// The board whose set points keys change.
    pub fn armed(&self) -> Option<usize> {
        self.armed.map(|(board, _)| board)
    }

    /// Where a channel is to go, kPa, while it is on its way.
    pub fn target(&self, place: Place) -> Option<f64> {
        self.ways.get(&place).map(|way| way.to_kpa)
    }

    /// Sends a channel of the armed board from `at_kpa` to `to_kpa`. `false` if its board is not
    /// armed.
    pub fn aim(&mut self, place: Place, at_kpa: f64, to_kpa: f64, now_ns: u64) -> bool {
        match &mut self.armed {
            Some((board, used_ns)) if *board == place.0 && place.1 < CHANNELS => *used_ns = now_ns,
            _ => return false,
        }
        if self.ways.is_empty() {
            self.stepped_ns = now_ns;
        }
        let at_kpa = self.ways.get(&place).map_or(at_kpa, |way| way.at_kpa);
        self.ways.insert(place, Way { at_kpa, to_kpa });
        true
    }

    /// The set points of now, kPa, of channels that are on their way.
    pub fn step(&mut self, now_ns: u64) -> Vec<(Place, f64)> {
        if self.armed.is_some_and(|(_, used_ns)| now_ns.saturating_sub(used_ns) > Self::IDLE_NS) {
            self.disarm();
        }
        let since_ns = now_ns.saturating_sub(std::mem::replace(&mut self.stepped_ns, now_ns));
        let most = Self::RATE_KPA_S * since_ns.min(Self::LONGEST_STEP_NS) as f64 * 1e-9;
        let steps = self.ways.iter_mut().map(|(&place, way)| {
            way.at_kpa = way.to_kpa.clamp(way.at_kpa - most, way.at_kpa + most);
            (place, way.at_kpa)
        });
        let steps: Vec<_> = steps.collect();
        self.ways.retain(|_, way| (way.at_kpa - way.to_kpa).abs() > 1e-9);
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn nothing_moves_unless_its_board_is_armed() {
        let mut jog = Jog::default();
        assert!(!jog.aim((0, 1), 0.0, 50.0, 0));
        jog.arm(0, 0);
        assert!(jog.aim((0, 1), 0.0, 50.0, 0) && !jog.aim((1, 1), 0.0, 50.0, 0));
        assert_eq!(jog.target((0, 1)), Some(50.0));
        jog.disarm();
        assert_eq!((jog.target((0, 1)), jog.step(50 * MS)), (None, Vec::new()));
    }

    #[test]
    fn a_set_point_is_reached_by_a_ramp_of_100_kpa_a_second() {
        let mut jog = Jog::default();
        jog.arm(2, 0);
        jog.aim((2, 3), 20.0, 50.0, 0);
        assert_eq!(jog.step(50 * MS), [((2, 3), 25.0)]);
        // A view that stood still for a second does not jump.
        assert_eq!(jog.step(1_050 * MS), [((2, 3), 35.0)]);
        // Another key on the way goes on from where it is.
        jog.aim((2, 3), 0.0, 30.0, 1_060 * MS);
        assert_eq!(jog.step(1_100 * MS), [((2, 3), 30.0)]);
        assert_eq!(jog.step(1_150 * MS), []);
    }

    #[test]
    fn a_board_that_is_not_used_is_disarmed() {
        let mut jog = Jog::default();
        jog.arm(0, 0);
        jog.aim((0, 0), 0.0, 1.0, 50_000 * MS);
        jog.step(110_000 * MS);
        assert_eq!(jog.armed(), Some(0));
        jog.step(110_001 * MS);
        assert_eq!(jog.armed(), None);
    }
}
