use super::SimError;
use pneudrive_protocol::Baud;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::{Errno, read, write};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr};
use std::ffi::OsString;
use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

/// The simulator's end of a pseudo-terminal whose other end clients open like a serial port.
#[derive(Debug)]
pub struct VirtualPort {
    master: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
}

/// What a pty is set to when it is made.
const ORDINARY_BAUD: u32 = 38_400;

/// What waiting for a client's bytes ended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wake {
    /// There are bytes to read.
    Bytes,
    /// The time has come.
    Timeout,
    /// No client has the port open.
    NoClient,
}

impl VirtualPort {
    /// Makes a pseudo-terminal in raw mode and, if asked for, a symbolic link to it.
    ///
    /// A symbolic link that leads nowhere is replaced (a simulator that was killed leaves one
    /// behind). One that leads to something may be another simulator's, whose clients would be on
    /// other boards the next time they open it; neither that nor a file is replaced.
    ///
    /// # Errors
    /// The system gives no pseudo-terminal, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, SimError> {
        let blocking = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let flags = blocking | OpenptFlags::from_bits_retain(OFlags::NONBLOCK.bits());
        let master = openpt(flags).map_err(SimError::pty("open"))?;
        grantpt(&master).map_err(SimError::pty("grant"))?;
        unlockpt(&master).map_err(SimError::pty("unlock"))?;
        let name = ptsname(&master, Vec::new()).map_err(SimError::pty("name"))?;
        let path = PathBuf::from(OsString::from_vec(name.into_bytes()));
        let mut port = Self { master, path, link: None };
        port.make_raw().map_err(SimError::pty("set up"))?;
        if let Some(link) = link {
            make_link(&port.path, link)?;
            port.link = Some(link.to_owned());
        }
        Ok(port)
    }

    /// The path that clients open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The client's end: for the measurement of the pty's own latency.
    pub(super) fn open_client(&self) -> rustix::io::Result<OwnedFd> {
        open(&self.path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())
    }

    fn make_raw(&self) -> rustix::io::Result<()> {
        let client = self.open_client()?;
        let found = tcgetattr(&client)?;
        let mut settings = found.clone();
        settings.make_raw();
        settings.special_codes = found.special_codes.clone();
        if self.raised_baud()?.is_some() {
            settings.set_speed(ORDINARY_BAUD)?;
        }
        // Only what differs: the next client may be setting its own in this moment, and must find
        // them afterwards.
        let modes = |of: &Termios| (of.input_modes, of.output_modes, of.control_modes, of.local_modes);
        if modes(&settings) == modes(&found) {
            Ok(())
        } else {
            tcsetattr(&client, OptionalActions::Now, &settings)
        }
    }

    /// What a client left unread must not greet the next one. A serial port forgets it when it is
    /// closed; a pty does not. The settings go back to raw mode too, and a raised line rate to an
    /// ordinary one; the rest stays, as a port's does.
    pub(super) fn forget_unread(&self) -> rustix::io::Result<()> {
        tcflush(self.open_client()?, QueueSelector::IFlush)?;
        self.make_raw()
    }

    /// 2 or 3 Mbaud, if the client has set its end to it. A pty knows no line rate, but it keeps
    /// what it is told.
    pub(super) fn raised_baud(&self) -> rustix::io::Result<Option<Baud>> {
        let set = tcgetattr(&self.master)?.output_speed();
        Ok([Baud::TWO_MBAUD, Baud::THREE_MBAUD].into_iter().find(|baud| baud.get() == set))
    }

    /// Sleeps until there are bytes, or for `timeout_ns`.
    pub(super) fn wait(&self, timeout_ns: u64) -> rustix::io::Result<Wake> {
        let mut fds = [PollFd::new(&self.master, PollFlags::IN)];
        let timeout = Timespec {
            tv_sec: i64::try_from(timeout_ns / 1_000_000_000).unwrap_or(i64::MAX),
            tv_nsec: (timeout_ns % 1_000_000_000) as _,
        };
        match poll(&mut fds, Some(&timeout)) {
            Ok(0) | Err(Errno::INTR) => Ok(Wake::Timeout),
            Ok(_) if fds[0].revents().contains(PollFlags::IN) => Ok(Wake::Bytes),
            Ok(_) => Ok(Wake::NoClient),
            Err(errno) => Err(errno),
        }
    }

    /// Reads what is there; `None` when no client has the port open.
    pub(super) fn read(&self, buffer: &mut [u8]) -> rustix::io::Result<Option<usize>> {
        match read(&self.master, buffer) {
            Ok(count) => Ok(Some(count)),
            Err(Errno::AGAIN | Errno::INTR) => Ok(Some(0)),
            Err(Errno::IO) => Ok(None),
            Err(errno) => Err(errno),
        }
    }

    /// Writes what fits; says how many bytes did not, because the client does not read.
    pub(super) fn write(&self, bytes: &[u8]) -> rustix::io::Result<usize> {
        let mut written = 0;
        while written < bytes.len() {
            match write(&self.master, &bytes[written..]) {
                Ok(0) | Err(Errno::AGAIN | Errno::IO) => break,
                Ok(count) => written += count,
                Err(Errno::INTR) => {}
                Err(errno) => return Err(errno),
            }
        }
        Ok(bytes.len() - written)
    }
}

impl Drop for VirtualPort {
    fn drop(&mut self) {
        // Another simulator may have taken the link over in the meantime.
        if let Some(link) = &self.link
            && fs::read_link(link).is_ok_and(|target| target == self.path)
        {
            let _ = fs::remove_file(link);
        }
    }
}

fn make_link(target: &Path, link: &Path) -> Result<(), SimError> {
    let refuse = |reason: String| SimError::Link { link: link.to_owned(), reason };
    match fs::symlink_metadata(link) {
        Ok(found) if !found.is_symlink() => {
            return Err(refuse("there is a file of this name, and it is no symbolic link".to_owned()));
        }
        Ok(_) => {
            let leads_to = fs::read_link(link).map_err(|error| refuse(error.to_string()))?;
            // The system gives numbers of ptys again: one that was left behind may lead here.
            if leads_to != target && link.exists() {
                return Err(refuse(format!(
                    "it leads to {} already, maybe of another simulator; end that, choose another name, or remove the link",
                    leads_to.display()
                )));
            }
            fs::remove_file(link).map_err(|error| refuse(error.to_string()))?;
        }
        Err(_) => {}
    }
    std::os::unix::fs::symlink(target, link).map_err(|error| refuse(error.to_string()))
}
