use super::backoff::Backoff;
use super::clock::timespec;
use super::name::Name;
use super::open::{open_exclusive, set_baud, unlock, wake_at};
use super::spin::{Lead, Spin};
use super::wait_strategy::{Trial, WaitStrategy};
use super::{Clock, Line, LineError, OpenError};
use crate::time::saturating_ns;
use pneudrive_protocol::Baud;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::{Errno, ioctl_fionread, read, write};
use rustix::rand::{GetRandomFlags, getrandom};
use rustix::termios::{OptionalActions, QueueSelector, Termios, tcflush, tcsetattr};
use rustix::thread::{ClockId, clock_nanosleep_absolute, sched_yield, set_current_timer_slack};
use std::num::NonZeroU64;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Settings of a serial port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct SerialOptions {
    /// Line rate; 8 data bits, no parity, one stop bit always.
    pub baud: Baud,
    /// Whether to look for bytes without sleeping: it saves the time that the kernel needs to wake
    /// a thread, at the price of that much CPU in each exchange.
    pub spin: Spin,
}

impl SerialOptions {
    /// Line rate.
    #[must_use]
    pub fn baud(self, baud: Baud) -> Self {
        Self { baud, ..self }
    }

    /// Whether to look for bytes without sleeping.
    #[must_use]
    pub fn spin(self, spin: Spin) -> Self {
        Self { spin, ..self }
    }
}

/// A serial port or pty, opened for this process alone. Its clock is CLOCK_MONOTONIC.
#[derive(Debug)]
pub struct SerialPort {
    path: PathBuf,
    /// `None` while the port is lost.
    file: Option<OwnedFd>,
    name: Name,
    settings: Termios,
    options: SerialOptions,
    /// The rate in effect.
    baud: Baud,
    /// Bytes from which on the kernel reports the port readable.
    wakes_at: usize,
    /// When the next answer is due, ns.
    due_ns: Option<u64>,
    lead: Lead,
    trial: Trial,
    sent_ns: u64,
}

impl SerialPort {
    /// How long `send` waits for room. A request is 10 bytes and the kernel buffers 4096: only a
    /// dead device is full.
    const SEND_PATIENCE_NS: u64 = 100_000_000;

    /// Opens `port` exclusively: raw, 8N1, no flow control, old bytes discarded.
    ///
    /// # Errors
    /// See [`OpenError`]; a port that another process holds is [`OpenError::InUse`].
    pub fn open(port: &Path, options: SerialOptions) -> Result<Self, OpenError> {
        let (file, settings) = open_exclusive(port, options.baud)?;
        let name = Name::of(port, &file);
        Ok(Self {
            path: port.to_owned(),
            file: Some(file),
            name,
            settings,
            baud: options.baud,
            options,
            wakes_at: 1,
            due_ns: None,
            lead: Lead::default(),
            trial: Trial::default(),
            sent_ns: 0,
        })
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The clock of its times.
    pub fn clock(&self) -> Clock {
        Clock
    }

    /// Lets the calling thread's sleeps end on time: the kernel otherwise adds up to 50 us to save
    /// power. Only for the thread that will use the port.
    pub fn precise_sleeps() {
        if let Err(error) = set_current_timer_slack(NonZeroU64::new(1)) {
            log::debug!("timer slack not set ({error}); sleeps may end 50 us late");
        }
    }

    fn file(&self) -> Result<&OwnedFd, LineError> {
        self.file.as_ref().ok_or_else(|| self.gone())
    }

    fn gone(&self) -> LineError {
        LineError::Gone { port: self.path.clone() }
    }

    fn close(&mut self) {
        if let Some(file) = self.file.take() {
            unlock(&file);
        }
    }

    /// Whether the other end still holds what is open here: the failure was one of being full, not
    /// of being gone.
    fn is_alive(&self) -> bool {
        let Some(file) = &self.file else { return false };
        let mut files = [PollFd::new(file, PollFlags::IN)];
        let over = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
        poll(&mut files, Some(&timespec(0))).is_ok() && !files[0].revents().intersects(over)
    }

    /// What is there now; 0 if nothing.
    fn look(&self, into: &mut [u8]) -> Result<usize, LineError> {
        match read(self.file()?, &mut *into) {
            // With O_NONBLOCK, "nothing there" is EAGAIN; 0 bytes means that the other end hung up.
            Ok(0) if !into.is_empty() => Err(self.gone()),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(errno) => Err(self.failed("read", errno)),
        }
    }

    /// Looks again and again for as long as the options allow; not at all where the deadline has
    /// passed or spinning is off.
    fn spin(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        let end_ns = match (self.options.spin, self.due_ns) {
            (Spin::Never, _) | (Spin::Auto, None) => return Ok(0),
            (Spin::BeforeSleep(duration), _) => self.now_ns() + saturating_ns(duration),
            (Spin::Auto, Some(_)) if self.trial.way() == WaitStrategy::Sleep => return Ok(0),
            (Spin::Auto, Some(_)) if self.trial.way() == WaitStrategy::BusyPoll => deadline_ns,
            (Spin::Auto, Some(due_ns)) => {
                let wake_ns = due_ns.saturating_sub(self.lead.ns()).min(deadline_ns);
                if self.now_ns() < wake_ns {
                    // An answer that is earlier than usual wakes it, or it would never be seen to
                    // be earlier.
                    self.wait(PollFlags::IN, wake_ns)?;
                    self.lead.woke(self.now_ns().saturating_sub(wake_ns));
                }
                due_ns.saturating_add(Lead::AFTER_NS)
            }
        };
        let end_ns = end_ns.min(deadline_ns);
        let overdue_ns = self.due_ns.map(|due_ns| due_ns.saturating_add(Lead::AFTER_NS));
        let mut have = 0;
        while have < wanted && self.now_ns() < end_ns {
            // A `read` that finds nothing waits for the kernel thread that carries a pty's or an
            // adapter's bytes; asking does not.
            match ioctl_fionread(self.file()?) {
                // An overdue answer's thread may wait for this core.
                Ok(0) if overdue_ns.is_some_and(|at_ns| self.now_ns() > at_ns) => sched_yield(),
                Ok(0) => std::hint::spin_loop(),
                Ok(_) => have += self.look(&mut into[have..])?,
                Err(errno) => return Err(self.failed("FIONREAD", errno)),
            }
        }
        Ok(have)
    }

    /// Sleeps until the port is ready for `what` or `deadline_ns` passes.
    fn wait(&self, what: PollFlags, deadline_ns: u64) -> Result<(), LineError> {
        let now = self.now_ns();
        if now >= deadline_ns {
            return Ok(());
        }
        let mut files = [PollFd::new(self.file()?, what)];
        match poll(&mut files, Some(&timespec(deadline_ns - now))) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(errno) => return Err(self.failed("poll", errno)),
        }
        let seen = files[0].revents();
        if seen.intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL)
            && !seen.intersects(PollFlags::IN)
        {
            return Err(self.gone());
        }
        Ok(())
    }

    fn failed(&self, what: &'static str, errno: Errno) -> LineError {
        let port = self.path.clone();
        match errno {
            Errno::IO | Errno::NODEV | Errno::NXIO | Errno::BADF => LineError::Gone { port },
            other => LineError::System { port, what, reason: other.to_string() },
        }
    }
}

impl Drop for SerialPort {
    fn drop(&mut self) {
        self.close();
    }
}

impl Line for SerialPort {
    fn now_ns(&self) -> u64 {
        Clock.now_ns()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        let mut left = bytes;
        let started = self.now_ns();
        self.sent_ns = started;
        while !left.is_empty() {
            match write(self.file()?, left) {
                Ok(count) => left = &left[count..],
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => {
                    let waited_ns = self.now_ns() - started;
                    if waited_ns >= Self::SEND_PATIENCE_NS {
                        let waited = Duration::from_nanos(waited_ns);
                        return Err(LineError::Stuck { port: self.path.clone(), waited });
                    }
                    self.wait(PollFlags::OUT, started + Self::SEND_PATIENCE_NS)?;
                }
                Err(errno) => return Err(self.failed("write", errno)),
            }
        }
        Ok(())
    }

    fn receive(&mut self, into: &mut [u8], wanted: usize, deadline_ns: u64) -> Result<usize, LineError> {
        let wanted = wanted.min(into.len());
        let mut backoff = Backoff::new(self.baud.characters_ns(1));
        let mut have = self.spin(into, wanted, deadline_ns)?;
        let due_ns = self.due_ns.take();
        if self.now_ns() >= deadline_ns {
            return Ok(have + self.look(&mut into[have..])?);
        }
        while have < wanted && self.now_ns() < deadline_ns {
            if wanted - have >= self.wakes_at {
                self.wait(PollFlags::IN, deadline_ns)?;
            } else {
                let end = backoff.next_end(self.now_ns(), deadline_ns);
                self.sleep_until(end);
            }
            have += self.look(&mut into[have..])?;
        }
        if have == wanted && due_ns.is_some() && self.options.spin == Spin::Auto {
            self.trial.seen(self.now_ns().saturating_sub(self.sent_ns));
        }
        Ok(have)
    }

    fn sleep_until(&mut self, at_ns: u64) {
        // Interrupted by a signal: sleep on. The signal's own handler tells whoever needs to know.
        while clock_nanosleep_absolute(ClockId::Monotonic, &timespec(at_ns)) == Err(Errno::INTR) {}
    }

    fn expect_bytes(&mut self, count: usize) {
        let Ok(bytes) = u8::try_from(count.max(1)) else { return };
        wake_at(&mut self.settings, bytes);
        let Some(file) = &self.file else { return };
        match tcsetattr(file, OptionalActions::Now, &self.settings) {
            Ok(()) => self.wakes_at = usize::from(bytes),
            Err(error) => log::debug!("{}: VMIN not set ({error})", self.path.display()),
        }
    }

    fn expect_answer_at(&mut self, at_ns: u64) {
        self.due_ns = Some(at_ns);
    }

    fn change_baud(&mut self, baud: Baud) -> Result<bool, LineError> {
        let file = self.file.as_ref().ok_or_else(|| LineError::Gone { port: self.path.clone() })?;
        let taken = set_baud(file, &mut self.settings, baud);
        let taken = taken.map_err(|errno| self.failed("setting the line rate", errno))?;
        self.baud = if taken { baud } else { self.baud };
        Ok(taken)
    }

    fn can_reopen(&self) -> bool {
        self.name != Name::Reassigned || self.is_alive()
    }

    fn reopen(&mut self) -> Result<(), OpenError> {
        if self.is_alive()
            && let Some(file) = &self.file
            && tcflush(file, QueueSelector::IOFlush).is_ok()
            && (self.baud == self.options.baud
                || set_baud(file, &mut self.settings, self.options.baud) == Ok(true))
        {
            self.baud = self.options.baud;
            return Ok(());
        }
        // As long as it is open, the system cannot give a device that returns its old name.
        self.close();
        let port = || self.path.clone();
        match self.name {
            Name::Reassigned => return Err(OpenError::NameGivenAway { port: port() }),
            name if !name.is_back(&self.path) => return Err(OpenError::NotFound { port: port() }),
            _ => {}
        }
        let (file, settings) = open_exclusive(&self.path, self.options.baud)?;
        self.name = Name::of(&self.path, &file);
        (self.file, self.settings, self.wakes_at) = (Some(file), settings, 1);
        self.baud = self.options.baud;
        Ok(())
    }

    /// From the kernel's generator (getrandom); from the clock only where that has not been seeded
    /// yet, early in a boot: nobody must wait for it.
    fn random(&mut self) -> u32 {
        let mut bytes = [0; 4];
        match getrandom(&mut bytes, GetRandomFlags::NONBLOCK) {
            Ok(4) => u32::from_ne_bytes(bytes),
            _ => (self.now_ns() / 1_000) as u32,
        }
    }

    fn cpu_time_ns(&self) -> u64 {
        Clock.cpu_time_ns()
    }
}
