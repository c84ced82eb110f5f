//! Venting everything at once, and set points by hand, whatever else gives commands.

use super::{
    AboveLimit, BoardCommand, CommandSource, Limits, NoSuchBoard, SetPoints, SourceStatus, VENTED, VentLatch,
};
use crate::Calibration;
use pneudrive_protocol::{CHANNELS, Counts};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Whose commands the boards get.
///
/// ```text
///   Following ──vent──▶ Vented ──release──▶ Manual
///                         ▲                   │
///                         └───────vent────────┘
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Commanding {
    /// Those of the source that was overridden.
    Following,
    /// 0 kPa for every channel, until released.
    Vented,
    /// Set points given by hand.
    Manual,
}

/// A handle for venting and commanding by hand. Clones are handles for the same boards.
///
/// Venting is one store and waits for nobody. It holds until it is released, also for boards that
/// are missing and come back, and what was commanded before does not return: after the release all
/// set points are 0 kPa, so nothing moves by itself. Where only the poller vented, because the port
/// was gone, the release returns to what was commanded before, by a ramp. The source that was
/// overridden is still asked, so a trajectory ends (and with it the run) when it would have ended.
///
/// Its latch is to be the poller's ([`latch`](Self::latch),
/// [`PollerOptions::vent`](super::PollerOptions::vent)).
#[derive(Debug, Clone)]
pub struct Override {
    latch: VentLatch,
    /// Whether set points by hand are followed while the latch is open.
    by_hand: Arc<AtomicBool>,
    set_points: SetPoints,
    boards: usize,
    /// Of each board in the poller's order.
    limits: Arc<Guard>,
    /// Held by those who change set points by hand; the bus thread never takes it.
    hands: Arc<Mutex<()>>,
}

/// What set points by hand are checked against.
#[derive(Debug, Clone, Default)]
struct Guard {
    /// Numbers of the boards in the poller's order.
    boards: Vec<u8>,
    limits: Limits,
    calibration: Calibration,
}

/// Why a set point was not taken.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OverrideError {
    /// The boards are vented.
    #[error("all boards are vented; release them first")]
    Vented,
    /// Something else commands.
    #[error("a trajectory commands the boards; vent and release them to command by hand")]
    Following,
    /// It is above the channel's limit.
    #[error(transparent)]
    AboveLimit(#[from] AboveLimit),
    /// There is no such board.
    #[error(transparent)]
    NoSuchBoard(#[from] NoSuchBoard),
    /// There is no such channel.
    #[error("no channel {channel}: a board has channels 0 to 3")]
    NoSuchChannel {
        /// The channel that was asked for.
        channel: usize,
    },
}

impl Override {
    /// Over a source that goes on commanding until somebody vents. `boards` as in the poller's
    /// order.
    pub fn following(boards: usize) -> Self {
        Self::new(SetPoints::new(boards), boards, false)
    }

    /// Set points by hand from the start, `initial` in the poller's order.
    pub fn manual(initial: &[BoardCommand]) -> Self {
        let set_points = SetPoints::new(initial.len());
        for (board, &command) in initial.iter().enumerate() {
            // There are as many as there are boards.
            let _ = set_points.set(board, command);
        }
        Self::new(set_points, initial.len(), true)
    }

    fn new(set_points: SetPoints, boards: usize, by_hand: bool) -> Self {
        Self {
            latch: VentLatch::default(),
            by_hand: Arc::new(AtomicBool::new(by_hand)),
            set_points,
            boards,
            limits: Arc::default(),
            hands: Arc::default(),
        }
    }

    /// Refuses set points by hand above these limits; `boards` are the boards' numbers in the
    /// poller's order. To be called before handles are given away.
    #[must_use]
    pub fn with_limits(self, boards: &[u8], limits: Limits, calibration: impl Into<Calibration>) -> Self {
        let (boards, calibration) = (boards.to_vec(), calibration.into());
        Self { limits: Arc::new(Guard { boards, limits, calibration }), ..self }
    }

    /// For [`PollerOptions::vent`](super::PollerOptions::vent): the poller closes it too, when a
    /// port comes back.
    pub fn latch(&self) -> VentLatch {
        self.latch.clone()
    }

    /// Puts itself over `source`.
    pub fn over(&self, source: Box<dyn CommandSource>) -> Box<dyn CommandSource> {
        Box::new(Overridden { source, handle: self.clone() })
    }

    /// Commands 0 kPa to all channels, from the next exchange with each board on, until
    /// [`release`](Self::release).
    pub fn vent(&self) {
        self.latch.vent();
    }

    /// Ends venting: set points by hand, all at 0 kPa; after an outage in which nobody vented,
    /// those of before. Does nothing if the boards are not vented.
    pub fn release(&self) {
        let _hands = self.hands.lock().unwrap_or_else(PoisonError::into_inner);
        if self.commanding() != Commanding::Vented {
            return;
        }
        if self.latch.by_hand() {
            for board in 0..self.boards {
                // All these boards exist.
                let _ = self.set_points.set(board, VENTED);
            }
            self.by_hand.store(true, Ordering::Relaxed);
        }
        // Who sees the latch open sees the two changes above.
        self.latch.release();
    }

    /// Commands one channel of the board at `index` in the poller's order.
    ///
    /// # Errors
    /// The boards are vented, something else commands, or there is no such channel.
    pub fn set(&self, index: usize, channel: usize, counts: Counts) -> Result<(), OverrideError> {
        let _hands = self.hands.lock().unwrap_or_else(PoisonError::into_inner);
        match self.commanding() {
            Commanding::Vented => return Err(OverrideError::Vented),
            Commanding::Following => return Err(OverrideError::Following),
            Commanding::Manual => {}
        }
        if channel >= CHANNELS {
            return Err(OverrideError::NoSuchChannel { channel });
        }
        let guard = &self.limits;
        if let Some(&board) = guard.boards.get(index) {
            guard.limits.check_counts(board, channel, counts, guard.calibration.channel(board, channel))?;
        }
        // A board that does not exist is refused by `set`.
        let mut command = self.set_points.get(index).unwrap_or(VENTED);
        command[channel] = counts;
        Ok(self.set_points.set(index, command)?)
    }

    /// Whether a release returns to what was commanded before the outage.
    pub fn returns(&self) -> bool {
        self.latch.is_vented() && !self.latch.by_hand()
    }

    /// Whose commands the boards get.
    pub fn commanding(&self) -> Commanding {
        if self.latch.is_vented() {
            Commanding::Vented
        } else if self.by_hand.load(Ordering::Relaxed) {
            Commanding::Manual
        } else {
            Commanding::Following
        }
    }

    /// The set points given by hand of the board at `index`.
    pub fn set_point(&self, index: usize) -> Option<BoardCommand> {
        self.set_points.get(index)
    }
}

struct Overridden {
    source: Box<dyn CommandSource>,
    handle: Override,
}

impl CommandSource for Overridden {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        let status = self.source.fill(since_start_ns, commands);
        match self.handle.commanding() {
            Commanding::Following => return status,
            Commanding::Vented => commands.fill(VENTED),
            Commanding::Manual => {
                self.handle.set_points.fill(since_start_ns, commands);
            }
        }
        // How fresh commands are that nobody follows does not matter.
        if status == SourceStatus::Ended { status } else { SourceStatus::Continues }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HIGH: BoardCommand = [Counts::saturating(300); CHANNELS];

    /// Commands 300 counts for 100 ns.
    struct Short;

    impl CommandSource for Short {
        fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
            commands.fill(HIGH);
            if since_start_ns < 100 { SourceStatus::Continues } else { SourceStatus::Ended }
        }
    }

    fn filled(source: &mut dyn CommandSource, at_ns: u64) -> [BoardCommand; 2] {
        let mut commands = [VENTED; 2];
        source.fill(at_ns, &mut commands);
        commands
    }

    #[test]
    fn what_was_commanded_before_does_not_come_back() {
        let handle = Override::following(2);
        let mut source = handle.over(Box::new(Short));
        assert_eq!(filled(&mut *source, 0), [HIGH; 2]);
        assert_eq!(handle.set(0, 0, Counts::MAX), Err(OverrideError::Following));
        handle.vent();
        assert_eq!(filled(&mut *source, 1), [VENTED; 2]);
        assert_eq!(handle.set(0, 0, Counts::MAX), Err(OverrideError::Vented));
        handle.release();
        assert_eq!(filled(&mut *source, 2), [VENTED; 2]);
        handle.set(1, 3, Counts::MAX).unwrap();
        assert_eq!(filled(&mut *source, 3), [VENTED, [VENTED[0], VENTED[1], VENTED[2], Counts::MAX]]);
        handle.vent();
        handle.release();
        assert_eq!(filled(&mut *source, 4), [VENTED; 2]);
    }

    #[test]
    fn a_release_of_what_is_not_vented_changes_nothing() {
        let handle = Override::manual(&[HIGH, VENTED]);
        handle.release();
        let mut source = handle.over(Box::new(SetPoints::new(2)));
        assert_eq!(filled(&mut *source, 0), [HIGH, VENTED]);
        let following = Override::following(2);
        following.release();
        assert_eq!(following.commanding(), Commanding::Following);
    }

    #[test]
    fn the_run_ends_when_the_source_ends_vented_or_not() {
        let handle = Override::following(2);
        let mut source = handle.over(Box::new(Short));
        handle.vent();
        assert_eq!(source.fill(99, &mut [VENTED; 2]), SourceStatus::Continues);
        assert_eq!(source.fill(100, &mut [VENTED; 2]), SourceStatus::Ended);
    }

    #[test]
    fn a_set_point_above_the_limit_is_refused_and_the_old_one_stays() {
        let mut limits = Limits::default();
        let max = super::super::ChannelLimit { max_kpa: 100.0, max_rate_kpa_s: f64::INFINITY };
        limits.set(7, 2, max).unwrap();
        let handle = Override::manual(&[VENTED; 2]).with_limits(&[3, 7], limits, Calibration::default());
        handle.set(0, 2, Counts::saturating(300)).unwrap();
        let refused = handle.set(1, 2, Counts::saturating(300)).unwrap_err();
        assert!(matches!(refused, OverrideError::AboveLimit(AboveLimit { board: 7, channel: 2, .. })));
        assert_eq!(handle.set_point(1), Some(VENTED));
        handle.set(1, 2, Counts::saturating(221)).unwrap();
    }

    #[test]
    fn boards_and_channels_that_do_not_exist_are_named() {
        let handle = Override::manual(&[VENTED; 2]);
        let refused = handle.set(2, 0, Counts::MAX).unwrap_err();
        assert_eq!(refused, OverrideError::NoSuchBoard(NoSuchBoard { index: 2, boards: 2 }));
        assert_eq!(handle.set(0, 4, Counts::MAX), Err(OverrideError::NoSuchChannel { channel: 4 }));
    }
}
