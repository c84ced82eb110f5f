use super::{
    CommandSource, Finished, Latest, Observer, PollerOptions, PollerPanicked, Polling, Snapshot,
    SourceStatus, StartError, VentLatch,
};
use crate::bus::Bus;
use crate::line::{Line, LineError, SerialPort};
use crate::statistics::Statistics;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// Polls boards on a thread of its own until it is stopped or dropped; then commands 0 kPa to all
/// of them.
#[derive(Debug)]
pub struct Poller<L: Line = SerialPort> {
    shared: Arc<Shared>,
    latest: Latest,
    vent: VentLatch,
    thread: Option<JoinHandle<(Finished, Bus<L>)>>,
}

/// Looks at a poller without owning it. Clones look at the same one.
#[derive(Debug, Clone)]
pub struct Monitor {
    shared: Arc<Shared>,
    latest: Latest,
    vent: VentLatch,
}

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    statistics_wanted: AtomicBool,
    statistics: Mutex<Option<Statistics>>,
}

/// A sleeping thread looks this often whether it is to stop, ns.
const ATTENTION_NS: u64 = 20_000_000;

impl<L: Line + Send + 'static> Poller<L> {
    /// Starts polling.
    ///
    /// # Errors
    /// The system has no thread to give, or not what [`PollerOptions::real_time`] asks for.
    pub fn start(
        bus: Bus<L>,
        options: PollerOptions,
        source: Box<dyn CommandSource>,
        mut observers: Vec<Box<dyn Observer>>,
    ) -> Result<Self, StartError> {
        let latest = Latest::default();
        let vent = options.vent.clone();
        observers.insert(0, Box::new(latest.clone()));
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let (started, starts) = std::sync::mpsc::sync_channel(1);
        let thread = std::thread::Builder::new().name("pneudrive-bus".into()).spawn(move || {
            SerialPort::precise_sleeps();
            let real_time = options.real_time.apply();
            let refused = real_time.is_err();
            // Whoever starts it waits for this.
            let _ = started.send(real_time);
            let mut polling = Polling::new(bus, options, source, observers);
            // Whatever happens in an observer, the boards are left safe first.
            let ended =
                catch_unwind(AssertUnwindSafe(|| if refused { Ok(()) } else { run(&mut polling, &theirs) }));
            let statistics = polling.finish();
            let safe = polling.make_safe();
            match ended {
                Err(panic) => resume_unwind(panic),
                Ok(ended) => {
                    let error = ended.err().or_else(|| safe.clone().err());
                    let not_safe =
                        safe.unwrap_or_else(|_| statistics.boards.iter().map(|b| b.board).collect());
                    let bus = polling.into_bus();
                    (Finished::new(statistics, error, not_safe).with_unheard(&bus), bus)
                }
            }
        })?;
        let poller = Self { shared, latest, vent, thread: Some(thread) };
        // Where the thread has died without a word, joining it says so.
        if let Ok(Err(error)) = starts.recv() {
            return Err(error.into());
        }
        Ok(poller)
    }
}

impl<L: Line> Poller<L> {
    /// For those who only look.
    pub fn monitor(&self) -> Monitor {
        Monitor { shared: Arc::clone(&self.shared), latest: self.latest.clone(), vent: self.vent.clone() }
    }

    /// As [`Monitor::latest`].
    pub fn latest(&self) -> Snapshot {
        self.latest.get()
    }

    /// As [`Monitor::statistics`].
    pub fn statistics(&self) -> Option<Statistics> {
        self.shared.statistics()
    }

    /// Closes it to vent all boards, opens it to follow the set points again. The poller closes it
    /// itself when a port comes back, unless [`PollerOptions::resume`] is set.
    pub fn vent(&self) -> &VentLatch {
        &self.vent
    }

    /// Whether the thread has ended by itself: the line failed, or the commands ended.
    pub fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends polling, commands 0 kPa to all boards until they have confirmed it
    /// ([`Polling::make_safe`]), closes the line.
    ///
    /// # Errors
    /// The bus thread panicked.
    pub fn stop(self) -> Result<Finished, PollerPanicked> {
        self.into_bus().map(|(finished, _)| finished)
    }

    /// As [`stop`](Self::stop), and hands back the bus, its line still open: for another poller, or
    /// for questions to single boards.
    ///
    /// # Errors
    /// The bus thread panicked.
    pub fn into_bus(mut self) -> Result<(Finished, Bus<L>), PollerPanicked> {
        self.join().ok_or(PollerPanicked)
    }

    fn join(&mut self) -> Option<(Finished, Bus<L>)> {
        self.shared.stop.store(true, Ordering::Relaxed);
        self.thread.take()?.join().ok()
    }
}

impl<L: Line> Drop for Poller<L> {
    fn drop(&mut self) {
        self.join();
    }
}

impl Monitor {
    /// Looks at rows that somebody else puts into `latest`.
    pub(crate) fn of(latest: Latest) -> Self {
        Self { shared: Arc::default(), latest, vent: VentLatch::default() }
    }

    /// Whether somebody has asked for figures since they were published.
    pub(crate) fn wants_statistics(&self) -> bool {
        self.shared.statistics_wanted.load(Ordering::Relaxed)
    }

    /// Figures for whoever asks next.
    pub(crate) fn publish(&self, statistics: Statistics) {
        *self.shared.statistics.lock().unwrap_or_else(PoisonError::into_inner) = Some(statistics);
        self.shared.statistics_wanted.store(false, Ordering::Relaxed);
    }

    /// As [`Poller::vent`].
    pub fn vent(&self) -> &VentLatch {
        &self.vent
    }

    /// The newest row. Look at its readings' age: a board that is gone keeps its last one.
    pub fn latest(&self) -> Snapshot {
        self.latest.get()
    }

    /// What the run has been like, as of the last time somebody asked; the bus thread then makes
    /// new figures at the end of its cycle. Called twice a second it gives figures that are half a
    /// second old.
    pub fn statistics(&self) -> Option<Statistics> {
        self.shared.statistics()
    }
}

impl Shared {
    fn statistics(&self) -> Option<Statistics> {
        self.statistics_wanted.store(true, Ordering::Relaxed);
        self.statistics.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn run<L: Line>(polling: &mut Polling<L>, shared: &Shared) -> Result<(), LineError> {
    while !shared.stop.load(Ordering::Relaxed) {
        let start_ns = polling.next_cycle_ns();
        let line = polling.bus_mut().line_mut();
        while line.now_ns() < start_ns && !shared.stop.load(Ordering::Relaxed) {
            let attention_ns = line.now_ns() + ATTENTION_NS;
            line.sleep_until(start_ns.min(attention_ns));
        }
        if polling.cycle()? == SourceStatus::Ended {
            break;
        }
        if shared.statistics_wanted.load(Ordering::Relaxed)
            && let Ok(mut place) = shared.statistics.try_lock()
        {
            *place = Some(polling.statistics());
            shared.statistics_wanted.store(false, Ordering::Relaxed);
        }
    }
    Ok(())
}
