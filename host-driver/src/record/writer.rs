//! The thread that writes.

use super::RecordError;
use super::file::BlockFile;
use super::format::Form;
use super::rows::Batch;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::time::{Duration, Instant};

/// How often a block is appended: what `kill -9` can cost, with the time a batch waits before it.
const BLOCK_EVERY: Duration = Duration::from_millis(500);
/// How often the disk is told to keep it: what a power failure can cost.
const SYNC_EVERY: Duration = Duration::from_secs(2);
/// A block is appended earlier when it has become this long.
const BLOCK_BYTES: usize = 1 << 20;

pub(super) struct Writer {
    file: BlockFile,
    form: Box<dyn Form>,
    rows_in_block: u64,
    rows_written: u64,
    /// Rows that this thread has yet to take.
    waiting: Arc<AtomicU64>,
}

impl Writer {
    /// Writes the header at once, so that a full disk is known before anything moves.
    pub(super) fn new(file: BlockFile, form: Box<dyn Form>) -> Result<Self, RecordError> {
        let mut writer = Self { file, form, rows_in_block: 0, rows_written: 0, waiting: Arc::default() };
        writer.append().and_then(|()| writer.accompany()).map_err(|error| writer.explain(&error))?;
        Ok(writer)
    }

    /// Rows that have been handed over and not been taken yet; whoever hands over adds to it.
    pub(super) fn waiting(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.waiting)
    }

    /// Writes batches until their senders are gone, and gives each back to the bus it came from. Returns rows and bytes in the file.
    pub(super) fn run(
        mut self,
        batches: &Receiver<Batch>,
        empty: &[SyncSender<Batch>],
    ) -> Result<(u64, u64), RecordError> {
        self.write(batches, empty).map_err(|error| self.explain(&error))?;
        Ok((self.rows_written, self.file.length()))
    }

    fn write(&mut self, batches: &Receiver<Batch>, empty: &[SyncSender<Batch>]) -> io::Result<()> {
        let mut appended = Instant::now();
        let mut synced = appended;
        loop {
            match batches.recv_timeout(BLOCK_EVERY) {
                Ok(mut batch) => {
                    self.form.add(&batch)?;
                    let rows = batch.rows() as u64;
                    self.rows_in_block += rows;
                    self.waiting.fetch_sub(rows, Ordering::Relaxed);
                    batch.clear();
                    if let Some(bus) = empty.get(batch.bus) {
                        // If the bus thread has enough empty ones, this one goes.
                        let _ = bus.try_send(batch);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    self.append()?;
                    let end = self.form.end()?;
                    self.file.append(&end)?;
                    self.file.sync()?;
                    return self.accompany();
                }
            }
            if appended.elapsed() >= BLOCK_EVERY || self.form.waiting() >= BLOCK_BYTES {
                self.append()?;
                appended = Instant::now();
            }
            if synced.elapsed() >= SYNC_EVERY {
                self.file.sync()?;
                synced = Instant::now();
            }
        }
    }

    fn append(&mut self) -> io::Result<()> {
        let block = self.form.block()?;
        self.file.append(&block)?;
        self.rows_written += std::mem::take(&mut self.rows_in_block);
        Ok(())
    }

    fn accompany(&self) -> io::Result<()> {
        match self.form.companion() {
            Some((name, content)) => self.file.write_beside(name, &content),
            None => Ok(()),
        }
    }

    fn explain(&self, error: &io::Error) -> RecordError {
        let file = self.file.path().to_owned();
        RecordError::Write { file, rows: self.rows_written, reason: error.to_string() }
    }
}
