//! What a controller owns: its port, the bus on it, and whoever polls it.

use super::ending::{Ending, LOOK_EVERY, Signals};
use super::guard::{RateGuard, Rules};
use super::interruptible::{Interrupt, Interruptible};
use super::owner::Owner;
use super::port::Port;
use super::session::{Session, Vented};
use crate::errors::{BusFailure, PortError};
use parking_lot::{Mutex, MutexGuard};
use pneudrive_host::bus::ExchangeError;
use pneudrive_protocol::{CHANNELS, Counts};
use pyo3::prelude::*;
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The bus of a controller.
pub type Bus = pneudrive_host::bus::Bus<Interruptible>;

/// Four pressures, kPa gauge.
type Reading = [f64; CHANNELS];

/// A port with boards. It outlives its controller only until the boards are vented.
pub struct Link {
    owner: Owner,
    devices: u16,
    path: PathBuf,
    interrupt: Interrupt,
    /// `None` only while it is destroyed.
    port: Option<Port>,
    /// Locked for as long as an exchange takes, so never with the interpreter's lock: see
    /// [`Self::lock_bus`]. `None` while it is polled, and after `close`.
    bus: Mutex<Option<Bus>>,
    /// Changed only while `bus` is locked. This lock and the next are held for an instant.
    status: Mutex<Status>,
    readings: Mutex<Vec<Option<Reading>>>,
    guard: RateGuard,
}

enum Status {
    Open,
    Polled(Arc<Session>),
    Closed { ending: Ending<Vented>, told: bool },
}

impl Link {
    /// Opens the port, for set points within `rules`. Call it without the interpreter's lock.
    ///
    /// # Errors
    /// `PortError`, or what a signal's handler raised.
    pub fn open(port: Port, devices: u16, rules: Rules) -> PyResult<Self> {
        let interrupt = Interrupt::default();
        let bus = port.open(&interrupt)?;
        Ok(Self {
            owner: Owner::this_process(),
            devices,
            path: port.path().to_owned(),
            interrupt,
            port: Some(port),
            bus: Mutex::new(Some(bus)),
            status: Mutex::new(Status::Open),
            readings: Mutex::new(vec![None; usize::from(devices)]),
            guard: RateGuard::new(rules, devices),
        })
    }

    /// Who may use it. To be checked before anything else: locks mean nothing in a forked child.
    pub fn owner(&self) -> Owner {
        self.owner
    }

    /// How many boards there are.
    pub fn devices(&self) -> u16 {
        self.devices
    }

    /// The port's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Highest set points, fastest changes, and what counts mean.
    pub fn rules(&self) -> &Rules {
        self.guard.rules()
    }

    /// Whether a command to `board` changes its set points no faster than allowed.
    ///
    /// # Errors
    /// It does not.
    pub fn check_rate(&self, board: u8, commands: [Counts; CHANNELS]) -> Result<(), BusFailure> {
        self.guard.check(board, commands).map_err(BusFailure::Refused)
    }

    /// Commands `board`, at most `retries` times more if it does not answer. Call it without the
    /// interpreter's lock.
    ///
    /// # Errors
    /// The last try's, or what a signal's handler raised.
    pub fn exchange(
        &self,
        board: u8,
        commands: [Counts; CHANNELS],
        retries: u32,
    ) -> Result<Reading, BusFailure> {
        let mut bus = self.lock_bus(Signals::Handled)?;
        let bus = self.opened(&mut bus)?;
        self.guard.send(board, commands).map_err(BusFailure::Refused)?;
        // Whatever happens, the old pressures are no longer the current ones.
        self.read(board, None);
        for tries_left in (0..=retries).rev() {
            match bus.exchange(board, commands) {
                Ok(answer) => {
                    let kpa = self.rules().calibration.kpa(board, answer.pressures);
                    self.read(board, Some(kpa));
                    return Ok(kpa);
                }
                Err(ExchangeError::Line(gone)) => return Err(self.failed(BusFailure::line(&gone))),
                Err(error) if tries_left == 0 => return Err(BusFailure::exchange(board, &error)),
                Err(_) if self.interrupt.is_closing() => return Err(closed()),
                Err(_) => Signals::Handled.look()?,
            }
        }
        // The last try has returned.
        Err(BusFailure::Port("nothing was tried".to_owned()))
    }

    /// The pressures of the last exchange with `board`, if it succeeded.
    pub fn reading(&self, board: u8) -> Option<Reading> {
        self.readings.lock().get(usize::from(board)).copied().flatten()
    }

    /// Gives the bus to a poller. Call it without the interpreter's lock.
    ///
    /// # Errors
    /// It is closed, is polled already, or cannot be opened again.
    pub fn poll(
        &self,
        start: impl FnOnce(Bus) -> PyResult<Arc<Session>>,
    ) -> Result<Arc<Session>, BusFailure> {
        let mut place = self.lock_bus(Signals::Handled)?;
        self.opened(&mut place)?;
        let Some(mut bus) = place.take() else {
            return Err(BusFailure::Port("the port is not open".to_owned()));
        };
        self.readings.lock().fill(None);
        self.guard.vented();
        bus.line_mut().leave_signals();
        let session = start(bus)?;
        *self.status.lock() = Status::Polled(Arc::clone(&session));
        Ok(session)
    }

    /// Whether a poller has the bus.
    pub fn is_polled(&self) -> bool {
        matches!(&*self.status.lock(), Status::Polled(session) if session.is_polling())
    }

    /// Whether it was closed.
    pub fn is_closed(&self) -> bool {
        matches!(&*self.status.lock(), Status::Closed { .. })
    }

    /// Ends a poller, commands 0 kPa to all boards and closes the port; `why` is what a poller says
    /// of its end. Of several calls, the first that is not interrupted returns how the boards were
    /// left. Call it without the interpreter's lock.
    ///
    /// # Errors
    /// What a signal's handler raised: then venting goes on, and the next call waits for it.
    pub fn close(&self, why: &str, signals: Signals) -> PyResult<Option<Vented>> {
        // Whoever is in an exchange by hand, comes out of it.
        self.interrupt.close();
        let ending = {
            let mut bus = self.lock_bus(signals)?;
            let mut status = self.status.lock();
            match &*status {
                Status::Closed { ending, .. } => ending.clone(),
                open => {
                    let ending = match (open, bus.take()) {
                        (Status::Polled(session), _) => session.end(why),
                        (_, Some(bus)) => vent(bus, self.devices),
                        // Whoever polled it has vented already.
                        (_, None) => Ending::start(Vented::default),
                    };
                    *status = Status::Closed { ending: ending.clone(), told: false };
                    ending
                }
            }
        };
        let vented = ending.wait(signals)?;
        self.readings.lock().fill(None);
        let told = match &mut *self.status.lock() {
            Status::Closed { told, .. } => mem::replace(told, true),
            _ => true,
        };
        Ok((!told).then_some(vented))
    }

    /// Waits for exchanges of other threads, which may need the interpreter's lock to look for
    /// signals.
    fn lock_bus(&self, signals: Signals) -> PyResult<MutexGuard<'_, Option<Bus>>> {
        loop {
            if let Some(bus) = self.bus.try_lock_for(LOOK_EVERY) {
                return Ok(bus);
            }
            signals.look()?;
        }
    }

    /// The bus, for use by hand. A poller that has ended gave it back by closing the port.
    fn opened<'a>(&self, bus: &'a mut Option<Bus>) -> Result<&'a mut Bus, BusFailure> {
        let failed = match &*self.status.lock() {
            Status::Open => None,
            Status::Closed { .. } => return Err(closed()),
            Status::Polled(session) if session.is_polling() => {
                return Err(BusFailure::Port(POLLED.to_owned()));
            }
            Status::Polled(session) => Some(Arc::clone(session)),
        };
        if let Some(session) = failed {
            // The port is free only when it has come to its end.
            session.end("it failed").wait(Signals::Handled)?;
            *self.status.lock() = Status::Open;
        }
        match bus {
            Some(bus) => Ok(bus),
            None => {
                let port = self.port.as_ref().ok_or_else(|| BusFailure::Port("no port".to_owned()))?;
                Ok(bus.insert(port.open(&self.interrupt)?))
            }
        }
    }

    /// A line that fails because a signal ended its waiting has not failed.
    fn failed(&self, failure: BusFailure) -> BusFailure {
        match self.interrupt.take() {
            Some(raised) => BusFailure::Python(raised),
            None if self.interrupt.is_closing() => closed(),
            None => failure,
        }
    }

    fn read(&self, board: u8, kpa: Option<Reading>) {
        if let Some(place) = self.readings.lock().get_mut(usize::from(board)) {
            *place = kpa;
        }
    }
}

/// What cannot be done by hand meanwhile, and what to do instead.
pub const POLLED: &str = "this controller is being polled: use the poller's set_pressure_commands and get_pressure_data, or stop \
                          the poller first";

fn closed() -> BusFailure {
    BusFailure::Port("this controller is closed".to_owned())
}

/// Commands 0 kPa to all boards and closes the port, whether somebody waits for it or not.
fn vent(mut bus: Bus, devices: u16) -> Ending<Vented> {
    Ending::start(move || {
        bus.line_mut().leave_signals();
        let boards = (0..=u8::MAX).take(usize::from(devices));
        match bus.make_safe(boards.clone()) {
            Ok(silent) => Vented { silent, failure: None },
            Err(error) => Vented { silent: boards.collect(), failure: Some(error.to_string()) },
        }
    })
}

impl Drop for Link {
    fn drop(&mut self) {
        if self.owner.is_other_process() {
            // Threads that this process does not have would be waited for, and the parent's port be
            // changed.
            mem::forget(self.bus.get_mut().take());
            mem::forget(self.port.take());
            mem::forget(mem::replace(self.status.get_mut(), Status::Open));
        }
    }
}

impl From<PyErr> for BusFailure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<BusFailure> for PyErr {
    fn from(failure: BusFailure) -> Self {
        failure.into_exception()
    }
}

/// Says that a port which cannot be opened is one of our own.
pub fn held_by_us(path: &Path) -> PyErr {
    PortError::new_err(format!(
        "{}: another PressureController of this program has it; close that one first",
        path.display()
    ))
}
