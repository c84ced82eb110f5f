//! The thread that writes.

use super::RecordError;
use super::file::BlockFile;
use super::rows::{Batch, Formatter};
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
    formatter: Formatter,
    text: Vec<u8>,
    rows_in_text: u64,
    rows_written: u64,
    /// Rows that this thread has yet to take.
    waiting: Arc<AtomicU64>,
}

impl Writer {
    /// Writes the header at once, so that a full disk is known before anything moves.
    pub(super) fn new(
        file: BlockFile,
        formatter: Formatter,
        waiting: Arc<AtomicU64>,
    ) -> Result<Self, RecordError> {
        let text = formatter.header();
        let mut writer = Self { file, formatter, text, rows_in_text: 0, rows_written: 0, waiting };
        writer.append().map_err(|error| writer.explain(&error))?;
        Ok(writer)
    }

    /// Writes batches until their sender is gone. Returns rows and bytes in the file.
    pub(super) fn run(
        mut self,
        batches: &Receiver<Batch>,
        empty: &SyncSender<Batch>,
    ) -> Result<(u64, u64), RecordError> {
        self.write(batches, empty).map_err(|error| self.explain(&error))?;
        Ok((self.rows_written, self.file.length()))
    }

    fn write(&mut self, batches: &Receiver<Batch>, empty: &SyncSender<Batch>) -> io::Result<()> {
        let mut appended = Instant::now();
        let mut synced = appended;
        loop {
            match batches.recv_timeout(BLOCK_EVERY) {
                Ok(mut batch) => {
                    self.formatter.append(&batch, &mut self.text);
                    let rows = batch.rows() as u64;
                    self.rows_in_text += rows;
                    self.waiting.fetch_sub(rows, Ordering::Relaxed);
                    batch.clear();
                    // If the bus thread has enough empty ones, this one goes.
                    let _ = empty.try_send(batch);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    self.append()?;
                    return self.file.sync();
                }
            }
            if appended.elapsed() >= BLOCK_EVERY || self.text.len() >= BLOCK_BYTES {
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
        if !self.text.is_empty() {
            self.file.append(&self.text)?;
            self.text.clear();
            self.rows_written += std::mem::take(&mut self.rows_in_text);
        }
        Ok(())
    }

    fn explain(&self, error: &io::Error) -> RecordError {
        let file = self.file.path().to_owned();
        RecordError::Write { file, rows: self.rows_written, reason: error.to_string() }
    }
}
