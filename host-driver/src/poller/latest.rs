//! The newest row, for threads that look now and then.

use super::{BoardRow, Observer, Reading, Row};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A copy of a row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshot {
    /// Cycles before this one; `None` before the first.
    pub cycle: Option<u64>,
    /// Start of the cycle, ns on the line's clock.
    pub at_ns: u64,
    /// Start of the cycle after that of the first cycle, ns.
    pub since_start_ns: u64,
    /// The boards in the order in which they are polled.
    pub boards: Vec<BoardRow>,
}

impl Snapshot {
    /// How long ago the cycle started; `None` before the first. It grows while the bus thread
    /// stands still.
    pub fn age(&self, now_ns: u64) -> Option<Duration> {
        self.cycle.map(|_| Duration::from_nanos(now_ns.saturating_sub(self.at_ns)))
    }

    /// The reading of the board at `index` in the poller's order, unless it is older than
    /// `oldest` at `now_ns`: what a control loop should use. `now_ns` is on the line's clock
    /// ([`SerialPort::clock`](crate::line::SerialPort::clock)).
    ///
    /// [`BoardRow::fresh`] says that a reading is of its row's cycle; this says that the row itself
    /// is not old.
    pub fn reading(&self, index: usize, now_ns: u64, oldest: Duration) -> Option<&Reading> {
        let reading = self.boards.get(index)?.reading.as_ref()?;
        (reading.age(now_ns) <= oldest).then_some(reading)
    }
}

/// Where the bus thread leaves its newest row. Neither side waits for the other: the bus thread
/// writes into whichever of two places nobody is reading.
#[derive(Debug, Clone, Default)]
pub struct Latest {
    places: Arc<[Mutex<Snapshot>; 2]>,
}

impl Latest {
    /// The newest row that is there.
    pub fn get(&self) -> Snapshot {
        let [first, second] = &*self.places;
        let first = locked(first).clone();
        let second = locked(second).clone();
        if first.cycle >= second.cycle { first } else { second }
    }

    fn put(&self, row: &Row<'_>) {
        // The place used last time comes second, so that a reader finds at least one complete row
        // at any time.
        let first = usize::from(row.cycle % 2 == 1);
        for place in [first, 1 - first] {
            let Ok(mut snapshot) = self.places[place].try_lock() else { continue };
            snapshot.cycle = Some(row.cycle);
            snapshot.at_ns = row.at_ns;
            snapshot.since_start_ns = row.since_start_ns;
            snapshot.boards.clear();
            snapshot.boards.extend_from_slice(row.boards);
            return;
        }
    }
}

fn locked(place: &Mutex<Snapshot>) -> MutexGuard<'_, Snapshot> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Observer for Latest {
    fn row(&mut self, row: &Row<'_>) {
        self.put(row);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cycle: u64) -> Row<'static> {
        Row { cycle, at_ns: 10 * cycle, since_start_ns: 10 * cycle, boards: &[] }
    }

    #[test]
    fn the_newest_row_wins() {
        let latest = Latest::default();
        assert_eq!(latest.get().cycle, None);
        for cycle in 0..5 {
            latest.put(&row(cycle));
            assert_eq!(latest.get().cycle, Some(cycle));
        }
    }

    #[test]
    fn a_reader_in_one_place_does_not_stop_the_writer() {
        let latest = Latest::default();
        latest.put(&row(0));
        let reading = locked(&latest.places[1]);
        latest.put(&row(1));
        drop(reading);
        assert_eq!(latest.get().cycle, Some(1));
    }
}
