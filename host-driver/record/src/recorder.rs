use super::file::BlockFile;
use super::format::{Form, Text};
use super::notes::{Note, Notes};
use super::rows::{Batch, Formatter, RecordedEvent};
use super::writer::Writer;
use super::{RecordError, RecorderOptions};
use pneudrive_host::Calibration;
use pneudrive_host::line::Clock;
use pneudrive_host::notices::{Notice, NoticeWriter};
use pneudrive_host::poller::{Event, Observer, Row};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, channel, sync_channel};
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

/// One of the buses whose boards are in a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedBus {
    /// Its boards, in the poller's order.
    pub boards: Vec<u8>,
    /// Number of the joint that board 0 moves; board n moves joint `first_joint + n`.
    pub first_joint: u16,
    /// What makes ns since 1970 of the times of its line: see
    /// [`Clock::unix_offset_ns`](pneudrive_host::line::Clock::unix_offset_ns).
    pub unix_offset_ns: u64,
}

/// Is called by the writing thread when it fails.
pub(super) type Failed = Box<dyn FnOnce(&RecordError) + Send>;

/// A recording in progress.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    waiting: Arc<AtomicU64>,
    notes: Notes,
    /// `None` when it has been joined.
    thread: Option<JoinHandle<Result<(u64, u64), RecordError>>>,
}

/// The end of a recorder that sits on the bus thread.
struct Tap {
    batch: Batch,
    batch_since_ns: u64,
    narrator: NoticeWriter,
    /// What has happened since the last row.
    happened: Vec<Notice>,
    /// Of the last row: its time on the line's clock and since the run's start, ns.
    last: (u64, u64),
    full: SyncSender<Batch>,
    empty: Receiver<Batch>,
    lost: Arc<AtomicU64>,
    waiting: Arc<AtomicU64>,
}

impl Recorder {
    /// Rows are handed over in batches of this length: waking the writer for each would cost the
    /// bus thread some us a cycle.
    const BATCH_NS: u64 = 20_000_000;
    /// Batches that may wait for the disk: 5 s of one bus.
    const QUEUE: usize = 250;
    /// What topics in a bag begin with: as if a ROS node of this name had published them.
    const TOPICS: &str = "/pneudrive";

    /// What [`create`](Self::create) would refuse without touching the disk: so that it is known
    /// before anything moves.
    ///
    /// # Errors
    /// A name that says no format, a file that exists (unless `overwrite`).
    pub fn check(path: &Path, overwrite: bool) -> Result<(), RecordError> {
        BlockFile::check(path, overwrite).map(drop)
    }

    /// Creates the file and writes its header. The observer is to be given to the poller; the
    /// recording ends when the poller has ended (and dropped it) and [`finish`](Self::finish) is
    /// called.
    ///
    /// # Errors
    /// A name that says no format, a file that exists (unless `overwrite`), a disk that takes no
    /// header.
    pub fn create(
        path: &Path,
        boards: &[u8],
        calibration: impl Into<Calibration>,
        overwrite: bool,
    ) -> Result<(Self, Box<dyn Observer>), RecordError> {
        let options = RecorderOptions::default().overwrite(overwrite);
        Self::create_with(path, boards, calibration, &options)
    }

    /// As [`create`](Self::create), with more to say about the run.
    ///
    /// # Errors
    /// As there.
    pub fn create_with(
        path: &Path,
        boards: &[u8],
        calibration: impl Into<Calibration>,
        options: &RecorderOptions,
    ) -> Result<(Self, Box<dyn Observer>), RecordError> {
        let calibration = calibration.into();
        let (recorder, mut taps) = Self::create_told(path, boards, &calibration, options, Box::new(|_| {}))?;
        let tap = taps.pop().ok_or_else(|| RecordError::NotCreated {
            file: path.to_owned(),
            reason: "it has no bus".into(),
        })?;
        Ok((recorder, tap))
    }

    /// As [`create_with`](Self::create_with); the writing thread calls `failed` when it fails.
    pub(super) fn create_told(
        path: &Path,
        boards: &[u8],
        calibration: &Calibration,
        options: &RecorderOptions,
        failed: Failed,
    ) -> Result<(Self, Vec<Box<dyn Observer>>), RecordError> {
        let file = BlockFile::create(path, options.overwrite)?;
        let unix_offset_ns = Clock.unix_offset_ns();
        let form: Box<dyn Form> = match file.format() {
            super::FileFormat::Mcap => {
                let bus = RecordedBus { boards: boards.to_vec(), first_joint: 0, unix_offset_ns };
                Self::bag(path, Self::TOPICS, &[bus], calibration, options)?
            }
            format => {
                let description = options.description.complete(&[boards.to_vec()], calibration);
                Box::new(Text::new(
                    format,
                    Formatter::new(boards, calibration, options.pages),
                    &description,
                    unix_offset_ns,
                ))
            }
        };
        Self::start(path, Writer::new(file, form)?, 1, failed)
    }

    /// Creates a bag of several buses, with topics `{prefix}/joint_{n}/...`, and an observer for
    /// each bus's poller.
    ///
    /// # Errors
    /// As [`create`](Self::create), and a name that does not end in `.mcap`: rows of several buses
    /// have no common time, so they have no place in one table.
    pub fn create_bag(
        path: &Path,
        prefix: &str,
        buses: &[RecordedBus],
        calibration: impl Into<Calibration>,
        overwrite: bool,
    ) -> Result<(Self, Vec<Box<dyn Observer>>), RecordError> {
        let options = RecorderOptions::default().overwrite(overwrite);
        Self::create_bag_with(path, prefix, buses, calibration, &options)
    }

    /// As [`create_bag`](Self::create_bag), with more to say about the run.
    ///
    /// # Errors
    /// As there.
    pub fn create_bag_with(
        path: &Path,
        prefix: &str,
        buses: &[RecordedBus],
        calibration: impl Into<Calibration>,
        options: &RecorderOptions,
    ) -> Result<(Self, Vec<Box<dyn Observer>>), RecordError> {
        Self::check_bag(path, options.overwrite)?;
        let file = BlockFile::create(path, options.overwrite)?;
        let form = Self::bag(path, prefix, buses, &calibration.into(), options)?;
        Self::start(path, Writer::new(file, form)?, buses.len(), Box::new(|_| {}))
    }

    /// As [`check`](Self::check), for [`create_bag`](Self::create_bag).
    ///
    /// # Errors
    /// As there.
    pub fn check_bag(path: &Path, overwrite: bool) -> Result<(), RecordError> {
        match BlockFile::check(path, overwrite)? {
            super::FileFormat::Mcap => Ok(()),
            _ => Err(RecordError::NotABag { file: path.to_owned() }),
        }
    }

    fn bag(
        path: &Path,
        prefix: &str,
        buses: &[RecordedBus],
        calibration: &Calibration,
        options: &RecorderOptions,
    ) -> Result<Box<dyn Form>, RecordError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let boards: Vec<_> = buses.iter().map(|bus| bus.boards.clone()).collect();
        let description = options.description.complete(&boards, calibration);
        let bag = super::bag::Bag::new(&name, prefix, buses, calibration, &description, options)
            .map_err(|error| RecordError::NotCreated { file: path.to_owned(), reason: error.to_string() })?;
        Ok(Box::new(bag))
    }

    fn start(
        path: &Path,
        writer: Writer,
        buses: usize,
        failed: Failed,
    ) -> Result<(Self, Vec<Box<dyn Observer>>), RecordError> {
        let (full, batches) = sync_channel(Self::QUEUE);
        let (notes, told) = channel::<Note>();
        let (waiting, lost) = (writer.waiting(), writer.lost());
        let mut used = Vec::new();
        let mut taps: Vec<Box<dyn Observer>> = Vec::new();
        for bus in 0..buses {
            let (give_back, empty) = sync_channel(4);
            used.push(give_back);
            let batch = Batch::of(bus);
            let (full, lost, waiting) = (full.clone(), Arc::clone(&lost), Arc::clone(&waiting));
            taps.push(Box::new(Tap {
                batch,
                batch_since_ns: 0,
                narrator: NoticeWriter::default(),
                happened: Vec::new(),
                last: (0, 0),
                full,
                empty,
                lost,
                waiting,
            }));
        }
        let thread = std::thread::Builder::new()
            .name("pneudrive-record".into())
            .spawn(move || writer.run(&batches, &used, &told).inspect_err(|error| failed(error)))
            .map_err(|error| RecordError::NotCreated { file: path.to_owned(), reason: error.to_string() })?;
        let (path, notes, thread) = (path.to_owned(), Notes::to(notes), Some(thread));
        Ok((Self { path, waiting, notes, thread }, taps))
    }

    /// For adding events that do not happen on the bus.
    pub fn notes(&self) -> Notes {
        self.notes.clone()
    }

    /// Says that nobody will add events any more: when the poller has ended too, so does the
    /// writing thread.
    pub(super) fn end(&self) {
        self.notes.end();
    }

    /// Whether writing has failed: no more rows will be recorded.
    pub fn has_failed(&self) -> bool {
        self.has_ended()
    }

    /// Whether the writing thread has ended: it failed, or it has written the last row after
    /// [`end`](Self::end).
    pub(super) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Rows that have been handed over and not been taken by the writing thread yet. Rows are lost
    /// when it is behind by 5 s: whoever polls faster than real time, in virtual time, waits for
    /// it.
    pub fn rows_waiting(&self) -> u64 {
        self.waiting.load(Ordering::Relaxed)
    }

    /// Waits until everything is written. To be called when the poller has ended.
    ///
    /// # Errors
    /// Writing failed, or the disk was too slow for some rows. What is in the file is whole.
    pub fn finish(mut self) -> Result<RecordingSummary, RecordError> {
        self.end();
        let file = self.path.clone();
        let panicked = || RecordError::Write {
            file: file.clone(),
            rows: 0,
            reason: "the writing thread panicked".into(),
        };
        let thread = self.thread.take().ok_or_else(panicked)?;
        let (rows, bytes) = thread.join().unwrap_or_else(|_| Err(panicked()))?;
        Ok(RecordingSummary { file, rows, bytes })
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

impl Tap {
    fn hand_over(&mut self) {
        let bus = self.batch.bus;
        let next = self.empty.try_recv().unwrap_or_else(|_| Batch::of(bus));
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

impl Tap {
    /// Dates what has happened since the row before: in the cycle of the row that comes.
    fn date(&mut self, (at_ns, since_start_ns): (u64, u64)) {
        for notice in self.happened.drain(..) {
            self.batch.happened(RecordedEvent { at_ns, since_start_ns, notice });
        }
    }
}

impl Observer for Tap {
    fn row(&mut self, row: &Row<'_>) {
        self.last = (row.at_ns, row.since_start_ns);
        self.date(self.last);
        self.batch.push(row);
        if row.at_ns.saturating_sub(self.batch_since_ns) >= Recorder::BATCH_NS {
            self.batch_since_ns = row.at_ns;
            self.hand_over();
        }
    }

    fn event(&mut self, event: &Event<'_>) {
        self.happened.extend(self.narrator.notice(event));
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        self.date(self.last);
        if !self.batch.is_empty() {
            self.hand_over();
        }
    }
}
