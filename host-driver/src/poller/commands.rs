//! Where a cycle's commands come from.

use crate::time::saturating_ns;
use pneudrive_protocol::{CHANNELS, Counts};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Commands of one board, channels 0 to 3.
pub type BoardCommand = [Counts; CHANNELS];

/// What is commanded before anybody says otherwise: 0 kPa.
pub const VENTED: BoardCommand = [Counts::ATMOSPHERE; CHANNELS];

/// Whether a source has more commands to give.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SourceStatus {
    /// Go on.
    Continues,
    /// Go on, but nobody has renewed these commands in time: they are 0 kPa.
    Stale,
    /// These were the last ones; the poller ends after this cycle.
    Ended,
}

/// Gives the commands of each cycle. Called on the bus thread: it must not block.
pub trait CommandSource: Send {
    /// Fills in the commands of all polled boards, in the poller's order, for a cycle that starts
    /// `since_start_ns` after the first.
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus;
}

/// Set points that any thread may change while the poller runs, without a lock: the four of one
/// board change together.
///
/// They hold until they are changed. A program that computes set points and may get stuck should
/// say how long they are good for: [`vent_after`](Self::vent_after). Otherwise the bus thread goes
/// on sending the last ones, and the boards, which hear from their host all the time, keep to them.
#[derive(Debug, Clone)]
pub struct SetPoints {
    /// Four 16-bit counts a board.
    boards: Arc<[AtomicU64]>,
    /// Counts calls of `set` and `renew`.
    renewals: Arc<AtomicU64>,
    /// How long a renewal is good for, ns.
    good_for_ns: Option<u64>,
    /// The renewal that was seen last by `fill`, and when.
    seen: (u64, u64),
}

impl SetPoints {
    /// For `boards` boards, all at 0 kPa.
    pub fn new(boards: usize) -> Self {
        Self {
            boards: (0..boards).map(|_| AtomicU64::new(pack(VENTED))).collect(),
            renewals: Arc::default(),
            good_for_ns: None,
            seen: (0, 0),
        }
    }

    /// Commands 0 kPa to all boards when no [`set`](Self::set) or [`renew`](Self::renew) has been
    /// called for `timeout`, until the next one. To be called before the set points are given to a
    /// poller.
    #[must_use]
    pub fn vent_after(self, timeout: Duration) -> Self {
        Self { good_for_ns: Some(saturating_ns(timeout)), ..self }
    }

    /// Sets the four commands of the board at `index` in the poller's order, from its next exchange
    /// on.
    ///
    /// # Errors
    /// There is no such board.
    pub fn set(&self, index: usize, command: BoardCommand) -> Result<(), NoSuchBoard> {
        let slot = self.boards.get(index).ok_or(NoSuchBoard { index, boards: self.boards.len() })?;
        slot.store(pack(command), Ordering::Relaxed);
        self.renew();
        Ok(())
    }

    /// Says that the set points are still meant.
    pub fn renew(&self) {
        self.renewals.fetch_add(1, Ordering::Relaxed);
    }

    /// The commands of the board at `index`.
    pub fn get(&self, index: usize) -> Option<BoardCommand> {
        self.boards.get(index).map(|slot| unpack(slot.load(Ordering::Relaxed)))
    }

    /// Whether the last renewal is too long ago.
    fn stale(&mut self, now_ns: u64) -> bool {
        let Some(good_for_ns) = self.good_for_ns else { return false };
        let renewals = self.renewals.load(Ordering::Relaxed);
        if renewals != self.seen.0 {
            self.seen = (renewals, now_ns);
        }
        now_ns.saturating_sub(self.seen.1) > good_for_ns
    }
}

impl CommandSource for SetPoints {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        if self.stale(since_start_ns) {
            commands.fill(VENTED);
            return SourceStatus::Stale;
        }
        for (slot, command) in self.boards.iter().zip(commands) {
            *command = unpack(slot.load(Ordering::Relaxed));
        }
        SourceStatus::Continues
    }
}

/// A board that is not polled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("no board {index}: {boards} boards are polled, counted from 0")]
#[non_exhaustive]
pub struct NoSuchBoard {
    /// The index that was asked for.
    pub index: usize,
    /// How many boards are polled.
    pub boards: usize,
}

fn pack(command: BoardCommand) -> u64 {
    command.iter().fold(0, |packed, counts| packed << 16 | u64::from(counts.get()))
}

fn unpack(packed: u64) -> BoardCommand {
    let mut command = VENTED;
    for (channel, counts) in command.iter_mut().enumerate() {
        let shift = 16 * (CHANNELS - 1 - channel);
        *counts = Counts::saturating((packed >> shift) as u16);
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_points_come_out_as_they_went_in() {
        let command = [1023, 0, 511, 102].map(|value| Counts::new(value).unwrap());
        let mut points = SetPoints::new(2);
        points.set(1, command).unwrap();
        let mut filled = [VENTED; 2];
        assert_eq!(points.fill(0, &mut filled), SourceStatus::Continues);
        assert_eq!(filled, [VENTED, command]);
        assert_eq!(points.set(2, command), Err(NoSuchBoard { index: 2, boards: 2 }));
    }

    #[test]
    fn set_points_that_nobody_renews_become_0_kpa() {
        let command = [Counts::saturating(511); CHANNELS];
        let points = SetPoints::new(1).vent_after(Duration::from_nanos(100));
        let (mut source, mut filled) = (points.clone(), [VENTED; 1]);
        let mut fill = |at_ns| (source.fill(at_ns, &mut filled), filled[0]);
        points.set(0, command).unwrap();
        assert_eq!(fill(1_000), (SourceStatus::Continues, command));
        assert_eq!(fill(1_100), (SourceStatus::Continues, command));
        assert_eq!(fill(1_101), (SourceStatus::Stale, VENTED));
        points.renew();
        assert_eq!(fill(1_200), (SourceStatus::Continues, command));
        assert_eq!(fill(1_301), (SourceStatus::Stale, VENTED));
    }

    #[test]
    fn set_points_hold_forever_unless_told_otherwise() {
        let mut points = SetPoints::new(1);
        points.set(0, [Counts::saturating(511); CHANNELS]).unwrap();
        assert_eq!(points.fill(u64::MAX, &mut [VENTED]), SourceStatus::Continues);
    }

    /// While another thread changes them all the time, the four commands of a board are always of
    /// one change.
    #[test]
    fn a_boards_commands_change_together() {
        let points = SetPoints::new(1);
        let writer = points.clone();
        let command = |value| [Counts::saturating(value); CHANNELS];
        points.set(0, command(0)).unwrap();
        let enough = Arc::new(std::sync::atomic::AtomicBool::new(false));
        let stop = Arc::clone(&enough);
        let thread = std::thread::spawn(move || {
            let values = (0..=Counts::MAX.get()).cycle();
            values
                .take_while(|_| !stop.load(Ordering::Relaxed))
                .for_each(|v| writer.set(0, command(v)).unwrap());
        });
        let mut changes = 0;
        let mut last = command(0);
        while changes < 1_000 {
            let now = points.get(0).unwrap();
            assert_eq!(now, [now[0]; CHANNELS]);
            changes += u32::from(now != last);
            last = now;
        }
        enough.store(true, Ordering::Relaxed);
        thread.join().unwrap();
    }
}
