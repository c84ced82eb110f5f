//! Opening a port: exclusively, raw, at any line rate.

use super::name::is_pty;
use super::{OpenError, low_latency};
use pneudrive_protocol::Baud;
use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, Termios, ioctl_tiocexcl, ioctl_tiocnxcl,
    isatty, tcflush, tcgetattr, tcsetattr,
};
use std::os::fd::OwnedFd;
use std::path::Path;

/// Opens `port` for this process alone and sets it to raw 8N1 at `baud`. Returns the file and its
/// settings.
pub(super) fn open_exclusive(port: &Path, baud: Baud) -> Result<(OwnedFd, Termios), OpenError> {
    let failed = |what| move |errno: Errno| explain(port, what, errno);
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = open(port, flags, Mode::empty()).map_err(failed("open"))?;
    if !isatty(&file) {
        return Err(OpenError::NotATerminal { port: port.to_owned() });
    }
    lock(port, &file)?;
    let mut settings = tcgetattr(&file).map_err(failed("reading the settings"))?;
    settings.make_raw();
    settings.control_modes |= ControlModes::CREAD | ControlModes::CLOCAL;
    settings.control_modes &= !(ControlModes::CSTOPB | ControlModes::CRTSCTS | ControlModes::PARENB);
    settings.set_speed(baud.get()).map_err(failed("setting the line rate"))?;
    wake_at(&mut settings, 1);
    tcsetattr(&file, OptionalActions::Now, &settings).map_err(failed("setting raw mode"))?;
    check_speed(port, &file, baud)?;
    low_latency::request(port);
    tcflush(&file, QueueSelector::IOFlush).map_err(failed("discarding old bytes"))?;
    Ok((file, settings))
}

/// From now on, the port counts as readable when `bytes` are there (VMIN, with VTIME at 0).
pub(super) fn wake_at(settings: &mut Termios, bytes: u8) {
    settings.special_codes[SpecialCodeIndex::VMIN] = bytes;
    settings.special_codes[SpecialCodeIndex::VTIME] = 0;
}

/// Both locks: `flock` keeps out another PneuDrive host, on ptys too and whoever runs it; TIOCEXCL
/// keeps out programs that do not ask. A pty outlives its users (the simulator holds it open), and
/// would keep TIOCEXCL after a kill -9.
fn lock(port: &Path, file: &OwnedFd) -> Result<(), OpenError> {
    flock(file, FlockOperation::NonBlockingLockExclusive).map_err(|errno| match errno {
        Errno::WOULDBLOCK => OpenError::InUse { port: port.to_owned() },
        other => explain(port, "locking", other),
    })?;
    if !is_pty(file) {
        ioctl_tiocexcl(file).map_err(|errno| explain(port, "exclusive mode", errno))?;
    }
    Ok(())
}

/// Gives both locks back. Closing alone would not where a forked child still has the file open.
pub(super) fn unlock(file: &OwnedFd) {
    // Whoever cannot be told now is told by the close.
    let _ = flock(file, FlockOperation::NonBlockingUnlock);
    if !is_pty(file) {
        let _ = ioctl_tiocnxcl(file);
    }
}

/// Drivers round the line rate; 8N1 tolerates about 2 % in all (half a bit in ten, shared by both
/// ends).
fn check_speed(port: &Path, file: &OwnedFd, baud: Baud) -> Result<(), OpenError> {
    let set = tcgetattr(file).map_err(|errno| explain(port, "reading the settings", errno))?;
    let (asked, got) = (baud.get(), set.output_speed());
    if is_near(asked, got) {
        return Ok(());
    }
    Err(OpenError::BaudRefused { port: port.to_owned(), asked, got })
}

fn is_near(asked: u32, got: u32) -> bool {
    got.abs_diff(asked) <= asked / 50
}

/// Sets another line rate and discards what has come. False if the driver refuses or rounds it:
/// then the rate is the one before.
pub(super) fn set_baud(file: &OwnedFd, settings: &mut Termios, baud: Baud) -> Result<bool, Errno> {
    let mut wanted = settings.clone();
    wanted.set_speed(baud.get())?;
    let taken = match tcsetattr(file, OptionalActions::Now, &wanted) {
        Ok(()) => is_near(baud.get(), tcgetattr(file)?.output_speed()),
        Err(Errno::INVAL) => false,
        Err(errno) => return Err(errno),
    };
    if taken {
        *settings = wanted;
    } else {
        tcsetattr(file, OptionalActions::Now, settings)?;
    }
    tcflush(file, QueueSelector::IFlush)?;
    Ok(taken)
}

fn explain(port: &Path, what: &'static str, errno: Errno) -> OpenError {
    let port = port.to_owned();
    match errno {
        Errno::NOENT | Errno::NODEV | Errno::NXIO => OpenError::NotFound { port },
        Errno::ACCESS | Errno::PERM => OpenError::NoPermission { port },
        Errno::BUSY => OpenError::InUse { port },
        Errno::NOTTY => OpenError::NotATerminal { port },
        other => OpenError::System { port, what, reason: other.to_string() },
    }
}
