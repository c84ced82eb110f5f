//! The thread that writes.

use super::RecordError;
use super::file::BlockFile;
use super::format::Form;
use super::notes::Note;
use super::rows::{Batch, RecordedEvent};
use pneudrive_host::notices::Notice;
use std::collections::VecDeque;
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
    /// Rows that were not handed over because the queue was full.
    lost: Arc<AtomicU64>,
    /// When the first cycle of the run started, ns on the line's clock; `None` before the first
    /// row.
    run_start_ns: Option<u64>,
    /// The time of the last row, ns on the line's clock.
    rows_until_ns: u64,
    /// What has happened after that row, which waits for the rows before it.
    early: VecDeque<(u64, Notice)>,
}

impl Writer {
    /// Writes the header at once, so that a full disk is known before anything moves.
    pub(super) fn new(file: BlockFile, form: Box<dyn Form>) -> Result<Self, RecordError> {
        let mut writer = Self {
            file,
            form,
            rows_in_block: 0,
            rows_written: 0,
            waiting: Arc::default(),
            lost: Arc::default(),
            run_start_ns: None,
            rows_until_ns: 0,
            early: VecDeque::new(),
        };
        writer.append().and_then(|()| writer.accompany()).map_err(|error| writer.explain(&error))?;
        Ok(writer)
    }

    /// Rows that have been handed over and not been taken yet; whoever hands over adds to it.
    pub(super) fn waiting(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.waiting)
    }

    /// Rows that were not handed over because there were too many; whoever hands over adds to it.
    pub(super) fn lost(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.lost)
    }

    /// Writes batches until their senders are gone, and gives each back to the bus it came from;
    /// then waits for the last of the `notes`. Returns rows and bytes in the file.
    pub(super) fn run(
        mut self,
        batches: &Receiver<Batch>,
        empty: &[SyncSender<Batch>],
        notes: &Receiver<Note>,
    ) -> Result<(u64, u64), RecordError> {
        self.write(batches, empty, notes).map_err(|error| self.explain(&error))?;
        match self.lost.load(Ordering::Relaxed) {
            0 => Ok((self.rows_written, self.file.length())),
            lost => Err(RecordError::TooSlow { file: self.file.path().to_owned(), lost }),
        }
    }

    fn write(
        &mut self,
        batches: &Receiver<Batch>,
        empty: &[SyncSender<Batch>],
        notes: &Receiver<Note>,
    ) -> io::Result<()> {
        let mut appended = Instant::now();
        let mut synced = appended;
        let mut ended = false;
        loop {
            match batches.recv_timeout(BLOCK_EVERY) {
                Ok(mut batch) => {
                    self.run_start_ns = self.run_start_ns.or(batch.run_start_ns());
                    self.rows_until_ns = self.rows_until_ns.max(batch.last_ns());
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
                    self.file.sync()?;
                    // How the run ended is known when the bus has.
                    while !ended && let Ok(note) = notes.recv() {
                        ended = self.take(note);
                    }
                    self.rows_until_ns = u64::MAX;
                    self.put_notices()?;
                    self.append()?;
                    let end = self.form.end()?;
                    self.file.append(&end)?;
                    self.file.sync()?;
                    return self.accompany();
                }
            }
            while let Ok(note) = notes.try_recv() {
                ended |= self.take(note);
            }
            self.put_notices()?;
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

    /// Takes a note. Whether it was the last one.
    fn take(&mut self, note: Note) -> bool {
        match note {
            Note::Happened { at_ns, notice } => {
                self.early.push_back((at_ns, notice));
                false
            }
            Note::End => true,
        }
    }

    /// Passes on what has happened before the last row.
    fn put_notices(&mut self) -> io::Result<()> {
        while let Some((at_ns, notice)) = self.early.pop_front_if(|(at_ns, _)| *at_ns <= self.rows_until_ns) {
            // What happens before the first cycle happens at 0.
            let since_start_ns = at_ns.saturating_sub(self.run_start_ns.unwrap_or(at_ns));
            self.form.happened(&RecordedEvent { at_ns, since_start_ns, notice })?;
        }
        Ok(())
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
