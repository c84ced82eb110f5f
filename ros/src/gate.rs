//! Which commands get through to the boards.

use pneudrive_host::messages::Time;
use pneudrive_host::poller::{BoardCommand, SetPoints, VENTED};
use pneudrive_protocol::{CHANNELS, SensorScale};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Why a command was not followed. What was commanded before stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Not four values.
    #[error("{found} values; a board has {CHANNELS} chambers")]
    WrongLength {
        /// How many came.
        found: usize,
    },
    /// NaN or an infinity.
    #[error("channel {channel}: {kpa} is no pressure")]
    NotFinite {
        /// Which of the four.
        channel: usize,
        /// What came.
        kpa: f64,
    },
    /// Negative, or more than the sensor can measure.
    #[error("channel {channel}: {reason}")]
    OutOfRange {
        /// Which of the four.
        channel: usize,
        /// What is allowed.
        reason: String,
    },
    /// Its stamp is too far from now.
    #[error("its stamp is {age_s:.3} s old; allowed are {limit_s} s (parameter max_command_age_s)")]
    Stale {
        /// Age; negative for a stamp in the future.
        age_s: f64,
        /// The limit.
        limit_s: f64,
    },
}

/// What has come to a joint's command topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Commands that were followed.
    pub accepted: u64,
    /// Commands that were not, by reason.
    pub wrong_length: u64,
    /// See [`Refusal::NotFinite`].
    pub not_finite: u64,
    /// See [`Refusal::OutOfRange`].
    pub out_of_range: u64,
    /// See [`Refusal::Stale`].
    pub stale: u64,
    /// How often the joint was vented because no command came.
    pub timeouts: u64,
}

impl Counters {
    /// All that were not followed.
    pub fn refused(&self) -> u64 {
        self.wrong_length + self.not_finite + self.out_of_range + self.stale
    }
}

/// Stands between the command topic of one joint and its board.
#[derive(Debug)]
pub struct Gate {
    set_points: SetPoints,
    /// The board's place in the poller's order.
    index: usize,
    scale: SensorScale,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    counters: Counters,
    /// When the last command was accepted, ns since 1970; `None` while the joint is vented for want of one.
    commanded_ns: Option<u64>,
}

impl Gate {
    /// For the board at `index` in the order of `set_points`.
    pub fn new(set_points: SetPoints, index: usize, scale: SensorScale) -> Self {
        Self { set_points, index, scale, state: Mutex::default() }
    }

    /// Follows a command of `kpa`, stamped `stamp`, that came at `now_ns` since 1970. A stamp of 0 counts as none. No age is too
    /// high if `max_age_ns` is 0.
    ///
    /// # Errors
    /// Why it was not followed; that is counted.
    pub fn offer(&self, stamp: Time, kpa: &[f64], now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
        let checked = fresh(stamp, now_ns, max_age_ns).and_then(|()| self.counts(kpa));
        let mut state = self.lock();
        let counters = &mut state.counters;
        match checked {
            Ok(command) => {
                counters.accepted += 1;
                state.commanded_ns = Some(now_ns);
                self.set(command);
                Ok(())
            }
            Err(refusal) => {
                match refusal {
                    Refusal::WrongLength { .. } => counters.wrong_length += 1,
                    Refusal::NotFinite { .. } => counters.not_finite += 1,
                    Refusal::OutOfRange { .. } => counters.out_of_range += 1,
                    Refusal::Stale { .. } => counters.stale += 1,
                }
                Err(refusal)
            }
        }
    }

    /// Vents the joint if its last command is older than `timeout_ns`; returns whether it did. Never if that is 0.
    pub fn expire(&self, now_ns: u64, timeout_ns: u64) -> bool {
        let mut state = self.lock();
        let expired = timeout_ns > 0
            && state
                .commanded_ns
                .is_some_and(|commanded_ns| now_ns.saturating_sub(commanded_ns) > timeout_ns);
        if expired {
            state.commanded_ns = None;
            state.counters.timeouts += 1;
            self.set(VENTED);
        }
        expired
    }

    /// What has come so far.
    pub fn counters(&self) -> Counters {
        self.lock().counters
    }

    fn counts(&self, kpa: &[f64]) -> Result<BoardCommand, Refusal> {
        if kpa.len() != CHANNELS {
            return Err(Refusal::WrongLength { found: kpa.len() });
        }
        let mut command = VENTED;
        for (channel, (counts, &kpa)) in command.iter_mut().zip(kpa).enumerate() {
            if !kpa.is_finite() {
                return Err(Refusal::NotFinite { channel, kpa });
            }
            *counts = self
                .scale
                .counts(kpa)
                .map_err(|error| Refusal::OutOfRange { channel, reason: error.to_string() })?;
        }
        Ok(command)
    }

    fn set(&self, command: BoardCommand) {
        if let Err(error) = self.set_points.set(self.index, command) {
            log::error!("{error}");
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn fresh(stamp: Time, now_ns: u64, max_age_ns: u64) -> Result<(), Refusal> {
    if max_age_ns == 0 || stamp.is_zero() || now_ns.abs_diff(stamp.unix_ns()) <= max_age_ns {
        return Ok(());
    }
    let age_s = (i128::from(now_ns) - i128::from(stamp.unix_ns())) as f64 * 1e-9;
    Err(Refusal::Stale { age_s, limit_s: max_age_ns as f64 * 1e-9 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW_NS: u64 = 1_763_742_822_000_000_000;
    const AGE_NS: u64 = 500_000_000;
    const KPA: [f64; 4] = [0.0, 100.0, 200.0, 300.0];

    fn gate() -> (Gate, SetPoints) {
        let points = SetPoints::new(2);
        (Gate::new(points.clone(), 1, SensorScale::ORIGINAL), points)
    }

    fn at(ns: u64) -> Time {
        Time::from_unix_ns(ns)
    }

    #[test]
    fn a_good_command_gets_through() {
        let (gate, points) = gate();
        for stamp in [at(NOW_NS), at(NOW_NS - AGE_NS), at(NOW_NS + AGE_NS), Time::default()] {
            gate.offer(stamp, &KPA, NOW_NS, AGE_NS).unwrap();
        }
        let counts = KPA.map(|kpa| SensorScale::ORIGINAL.counts(kpa).unwrap());
        assert_eq!((points.get(0), points.get(1)), (Some(VENTED), Some(counts)));
        assert_eq!(gate.counters(), Counters { accepted: 4, ..Counters::default() });
    }

    #[test]
    fn a_bad_one_changes_nothing_and_is_counted() {
        let (gate, points) = gate();
        gate.offer(at(NOW_NS), &KPA, NOW_NS, AGE_NS).unwrap();
        let before = points.get(1);
        let offers: [(u64, &[f64]); 8] = [
            (NOW_NS, &[1.0, 2.0, 3.0]),
            (NOW_NS, &[1.0; 5]),
            (NOW_NS, &[]),
            (NOW_NS, &[1.0, 2.0, f64::NAN, 4.0]),
            (NOW_NS, &[1.0, 2.0, 3.0, f64::INFINITY]),
            (NOW_NS, &[-1.0, 2.0, 3.0, 4.0]),
            (NOW_NS - AGE_NS - 1_000, &KPA),
            (NOW_NS + AGE_NS + 1_000, &KPA),
        ];
        for (stamp_ns, kpa) in offers {
            gate.offer(at(stamp_ns), kpa, NOW_NS, AGE_NS).unwrap_err();
        }
        gate.offer(at(NOW_NS), &[776.0; 4], NOW_NS, AGE_NS).unwrap_err();
        assert_eq!(points.get(1), before);
        let expected =
            Counters { accepted: 1, wrong_length: 3, not_finite: 2, out_of_range: 2, stale: 2, timeouts: 0 };
        assert_eq!(gate.counters(), expected);
        assert_eq!(expected.refused(), 9);
    }

    #[test]
    fn no_age_is_too_high_without_a_limit() {
        let (gate, _) = gate();
        gate.offer(at(1), &KPA, NOW_NS, 0).unwrap();
    }

    #[test]
    fn a_joint_without_commands_is_vented_once() {
        let (gate, points) = gate();
        assert!(!gate.expire(NOW_NS, AGE_NS), "nothing was commanded yet");
        gate.offer(at(NOW_NS), &KPA, NOW_NS, AGE_NS).unwrap();
        assert!(!gate.expire(NOW_NS + AGE_NS, AGE_NS));
        assert!(!gate.expire(NOW_NS + 100 * AGE_NS, 0), "switched off");
        assert!(gate.expire(NOW_NS + AGE_NS + 1, AGE_NS));
        assert!(!gate.expire(NOW_NS + 2 * AGE_NS, AGE_NS), "it is vented already");
        assert_eq!((points.get(1), gate.counters().timeouts), (Some(VENTED), 1));
    }
}
