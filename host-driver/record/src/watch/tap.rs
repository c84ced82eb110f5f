//! Rows from the bus thread to the program.

use super::state::WatchStatus;
use crate::{Batch, Formatter};
use pneudrive_host::poller::{Event, Observer, Row};
use std::io::Write;
use std::process::ChildStdin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

/// Rows are handed over in batches of this length, ns: waking the writer for each would cost the
/// bus thread some us a cycle.
const BATCH_NS: u64 = 50_000_000;
/// Batches that may wait for the program: 10 s.
const QUEUE: usize = 200;

/// The end on the bus thread.
pub(super) struct Tap {
    batch: Batch,
    batch_since_ns: u64,
    full: SyncSender<Batch>,
    status: WatchStatus,
}

impl Tap {
    /// The end on the bus thread and that of the writer.
    pub(super) fn new(status: WatchStatus) -> (Self, Receiver<Batch>) {
        let (full, batches) = sync_channel(QUEUE);
        (Self { batch: Batch::of(0), batch_since_ns: 0, full, status }, batches)
    }

    fn hand_over(&mut self) {
        let batch = std::mem::replace(&mut self.batch, Batch::of(0));
        if let Err(TrySendError::Full(batch)) = self.full.try_send(batch) {
            let rows = batch.rows() as u64;
            self.status.change(|state| state.rows_left_out += rows);
        }
    }
}

impl Observer for Tap {
    fn row(&mut self, row: &Row<'_>) {
        self.batch.push(row);
        if row.at_ns.saturating_sub(self.batch_since_ns) >= BATCH_NS {
            self.batch_since_ns = row.at_ns;
            self.hand_over();
        }
    }

    fn event(&mut self, _: &Event<'_>) {}
}

impl Drop for Tap {
    fn drop(&mut self) {
        if self.batch.rows() > 0 {
            self.hand_over();
        }
    }
}

/// Writes batches as they come, until the program takes no more or the bus thread has ended; that
/// is noted in `ending` before the program can know.
pub(super) fn write(
    batches: &Receiver<Batch>,
    formatter: &Formatter,
    mut program: ChildStdin,
    ending: &AtomicBool,
) {
    let mut text = Vec::new();
    while let Ok(batch) = batches.recv() {
        text.clear();
        formatter.append(&batch, &mut text);
        if program.write_all(&text).and_then(|()| program.flush()).is_err() {
            return;
        }
    }
    ending.store(true, Ordering::SeqCst);
}
