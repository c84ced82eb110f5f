use super::SimError;
use nix::errno::Errno;
use nix::fcntl::{OFlag, open};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll, ppoll};
use nix::pty::{PtyMaster, grantpt, posix_openpt, ptsname_r, unlockpt};
use nix::sys::stat::Mode;
use nix::sys::termios::{
    BaudRate, ControlFlags, FlushArg, SetArg, Termios, cfmakeraw, cfsetspeed, tcflush, tcgetattr, tcsetattr,
};
use nix::sys::time::{TimeSpec, TimeValLike};
use nix::unistd::{read, write};
use pneudrive_protocol::Baud;
use std::fs;
use std::os::fd::{AsFd, OwnedFd};
use std::path::{Path, PathBuf};

/// The simulator's end of a pseudo-terminal whose other end clients open like a serial port.
#[derive(Debug)]
pub struct VirtualPort {
    master: PtyMaster,
    path: PathBuf,
    link: Option<PathBuf>,
}

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
        let flags = OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_NONBLOCK | OFlag::O_CLOEXEC;
        let master = posix_openpt(flags).map_err(SimError::pty("open"))?;
        grantpt(&master).map_err(SimError::pty("grant"))?;
        unlockpt(&master).map_err(SimError::pty("unlock"))?;
        let path = PathBuf::from(ptsname_r(&master).map_err(SimError::pty("name"))?);
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
    pub(super) fn open_client(&self) -> nix::Result<OwnedFd> {
        open(&self.path, OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_CLOEXEC, Mode::empty())
    }

    fn make_raw(&self) -> nix::Result<()> {
        let client = self.open_client()?;
        let found = tcgetattr(&client)?;
        let mut settings = found.clone();
        cfmakeraw(&mut settings);
        settings.control_chars = found.control_chars;
        if self.raised_baud()?.is_some() {
            cfsetspeed(&mut settings, BaudRate::B38400)?;
        }
        // Only what differs: the next client may be setting its own in this moment, and must find
        // them afterwards. Flag by flag: a `Termios` keeps the characters that `cfmakeraw` has set
        // beside those that were put back, and differs where VMIN is not 1.
        let flags = |of: &Termios| (of.input_flags, of.output_flags, of.control_flags, of.local_flags);
        if flags(&settings) == flags(&found) {
            Ok(())
        } else {
            tcsetattr(&client, SetArg::TCSANOW, &settings)
        }
    }

    /// What a client left unread must not greet the next one. A serial port forgets it when it is
    /// closed; a pty does not. The settings go back to raw mode too, and a raised line rate to an
    /// ordinary one; the rest stays, as a port's does.
    pub(super) fn forget_unread(&self) -> nix::Result<()> {
        tcflush(self.open_client()?, FlushArg::TCIFLUSH)?;
        self.make_raw()
    }

    /// 2 or 3 Mbaud, if the client has set its end to it. A pty knows no line rate, but it keeps
    /// what it is told.
    pub(super) fn raised_baud(&self) -> nix::Result<Option<Baud>> {
        // `cfgetospeed` panics at rates that have no code of their own.
        let code = (tcgetattr(&self.master)?.control_flags & ControlFlags::CBAUD).bits();
        let raised = [(BaudRate::B2000000, Baud::TWO_MBAUD), (BaudRate::B3000000, Baud::THREE_MBAUD)];
        Ok(raised.into_iter().find(|(known, _)| *known as u32 == code).map(|(_, baud)| baud))
    }

    /// Sleeps until there are bytes, or for `timeout_ns`.
    pub(super) fn wait(&self, timeout_ns: u64) -> nix::Result<Wake> {
        let mut fds = [PollFd::new(self.master.as_fd(), PollFlags::POLLIN)];
        let result = if timeout_ns == 0 {
            poll(&mut fds, PollTimeout::ZERO)
        } else {
            let timeout = TimeSpec::nanoseconds(i64::try_from(timeout_ns).unwrap_or(i64::MAX));
            ppoll(&mut fds, Some(timeout), None)
        };
        match result {
            Ok(0) | Err(Errno::EINTR) => return Ok(Wake::Timeout),
            Ok(_) => {}
            Err(errno) => return Err(errno),
        }
        let events = fds[0].revents().unwrap_or(PollFlags::empty());
        Ok(if events.contains(PollFlags::POLLIN) { Wake::Bytes } else { Wake::NoClient })
    }

    /// Reads what is there; `None` when no client has the port open.
    pub(super) fn read(&self, buffer: &mut [u8]) -> nix::Result<Option<usize>> {
        match read(&self.master, buffer) {
            Ok(count) => Ok(Some(count)),
            Err(Errno::EAGAIN | Errno::EINTR) => Ok(Some(0)),
            Err(Errno::EIO) => Ok(None),
            Err(errno) => Err(errno),
        }
    }

    /// Writes what fits; says how many bytes did not, because the client does not read.
    pub(super) fn write(&self, bytes: &[u8]) -> nix::Result<usize> {
        let mut written = 0;
        while written < bytes.len() {
            match write(&self.master, &bytes[written..]) {
                Ok(0) | Err(Errno::EAGAIN | Errno::EIO) => break,
                Ok(count) => written += count,
                Err(Errno::EINTR) => {}
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
