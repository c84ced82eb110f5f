use super::RecordError;
use super::file::BlockFile;
use super::rows::{Batch, Formatter};
use super::writer::Writer;
use crate::poller::{Observer, Row};
use pneudrive_protocol::SensorScale;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// What is in a finished recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordingSummary {
    /// The file.
    pub file: PathBuf,
    /// Rows below the header.
    pub rows: u64,
    /// Size of the file.
    pub bytes: u64,
}

/// A recording in progress.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    lost: Arc<AtomicU64>,
    waiting: Arc<AtomicU64>,
    thread: JoinHandle<Result<(u64, u64), RecordError>>,
}

/// The end of a recorder that sits on the bus thread.
struct Tap {
    batch: Batch,
    batch_since_ns: u64,
    full: SyncSender<Batch>,
    empty: Receiver<Batch>,
    lost: Arc<AtomicU64>,
    waiting: Arc<AtomicU64>,
}

impl Recorder {
    /// Rows are handed over in batches of this length: waking the writer for each would cost the bus thread some us a cycle.
    const BATCH_NS: u64 = 20_000_000;
    /// Batches that may wait for the disk: 5 s.
    const QUEUE: usize = 250;

    /// What [`create`](Self::create) would refuse without touching the disk: so that it is known before anything moves.
    ///
    /// # Errors
    /// A name that says no format, a file that exists (unless `overwrite`).
    pub fn check(path: &Path, overwrite: bool) -> Result<(), RecordError> {
        BlockFile::check(path, overwrite).map(drop)
    }

    /// Creates the file and writes its header. The observer is to be given to the poller; the recording ends when the poller has
    /// ended (and dropped it).
    ///
    /// # Errors
    /// A name that says no format, a file that exists (unless `overwrite`), a disk that takes no header.
    pub fn create(
        path: &Path,
        boards: &[u8],
        scale: SensorScale,
        overwrite: bool,
    ) -> Result<(Self, Box<dyn Observer>), RecordError> {
        let waiting = Arc::new(AtomicU64::new(0));
        let formatter = Formatter::new(boards, scale);
        let writer = Writer::new(BlockFile::create(path, overwrite)?, formatter, Arc::clone(&waiting))?;
        let (full, batches) = sync_channel(Self::QUEUE);
        let (used, empty) = sync_channel(4);
        let lost = Arc::new(AtomicU64::new(0));
        let tap = Tap {
            batch: Batch::default(),
            batch_since_ns: 0,
            full,
            empty,
            lost: Arc::clone(&lost),
            waiting: Arc::clone(&waiting),
        };
        let thread = std::thread::Builder::new()
            .name("pneudrive-record".into())
            .spawn(move || writer.run(&batches, &used))
            .map_err(|error| RecordError::NotCreated { file: path.to_owned(), reason: error.to_string() })?;
        Ok((Self { path: path.to_owned(), lost, waiting, thread }, Box::new(tap)))
    }

    /// Whether writing has failed: no more rows will be recorded.
    pub fn has_failed(&self) -> bool {
        self.thread.is_finished()
    }

    /// Rows that have been handed over and not been taken by the writing thread yet. Rows are lost when it is behind by 5 s:
    /// whoever polls faster than real time, in virtual time, waits for it.
    pub fn rows_waiting(&self) -> u64 {
        self.waiting.load(Ordering::Relaxed)
    }

    /// Waits until everything is written. To be called when the poller has ended.
    ///
    /// # Errors
    /// Writing failed, or the disk was too slow for some rows. What is in the file is whole.
    pub fn finish(self) -> Result<RecordingSummary, RecordError> {
        let file = self.path;
        let written = self.thread.join().unwrap_or_else(|_| {
            Err(RecordError::Write {
                file: file.clone(),
                rows: 0,
                reason: "the writing thread panicked".into(),
            })
        });
        let (rows, bytes) = written?;
        match self.lost.load(Ordering::Relaxed) {
            0 => Ok(RecordingSummary { file, rows, bytes }),
            lost => Err(RecordError::TooSlow { file, lost }),
        }
    }
}

impl Tap {
    fn hand_over(&mut self) {
        let next = self.empty.try_recv().unwrap_or_default();
        let batch = std::mem::replace(&mut self.batch, next);
        let rows = batch.rows() as u64;
        self.waiting.fetch_add(rows, Ordering::Relaxed);
        if let Err(refused) = self.full.try_send(batch) {
            self.waiting.fetch_sub(rows, Ordering::Relaxed);
            if matches!(refused, TrySendError::Full(_)) {
                self.lost.fetch_add(rows, Ordering::Relaxed);
            }
        }
    }
}

impl Observer for Tap {
    fn row(&mut self, row: &Row<'_>) {
        self.batch.push(row);
        if row.at_ns.saturating_sub(self.batch_since_ns) >= Recorder::BATCH_NS {
            self.batch_since_ns = row.at_ns;
            self.hand_over();
        }
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        if self.batch.rows() > 0 {
            self.hand_over();
        }
    }
}
