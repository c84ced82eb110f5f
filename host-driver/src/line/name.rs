//! Whether a port that comes back under its old name is the same port.

use rustix::fs::{fstat, major};
use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Major device numbers of pty slaves on Linux (Documentation/admin-guide/devices.txt).
const PTY_SLAVE_MAJORS: std::ops::RangeInclusive<u32> = 136..=143;

/// Whether `file` is the client's end of a pseudo-terminal.
pub(super) fn is_pty(file: &OwnedFd) -> bool {
    fstat(file).is_ok_and(|status| PTY_SLAVE_MAJORS.contains(&major(status.st_rdev)))
}

/// How a lost port's name can be trusted.
///
/// The name of a serial port belongs to its socket or, in /dev/serial/by-id, to the adapter. The
/// name of a pseudo-terminal is given to the next one that anybody opens, a shell perhaps: there a
/// link that was made anew is the sign that the other end is back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Name {
    /// A device's own name.
    Permanent,
    /// A link to a pseudo-terminal, and which one.
    Link(Link),
    /// A pseudo-terminal's own name, which goes to the next one that is opened.
    Reassigned,
}

/// Tells a link from another one of the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Link {
    inode: u64,
    /// s and ns.
    changed: (i64, i64),
}

impl Link {
    fn at(path: &Path) -> Option<Self> {
        let status = fs::symlink_metadata(path).ok()?;
        let link = Self { inode: status.ino(), changed: (status.ctime(), status.ctime_nsec()) };
        status.file_type().is_symlink().then_some(link)
    }
}

impl Name {
    /// What `port` is, which has been opened as `file`.
    pub(super) fn of(port: &Path, file: &OwnedFd) -> Self {
        match (is_pty(file), Link::at(port)) {
            (false, _) => Self::Permanent,
            (true, Some(link)) => Self::Link(link),
            (true, None) => Self::Reassigned,
        }
    }

    /// Whether the port that is now at `port` can be the lost one.
    pub(super) fn is_back(self, port: &Path) -> bool {
        match self {
            Self::Permanent => true,
            Self::Link(before) => Link::at(port).is_some_and(|now| now != before),
            Self::Reassigned => false,
        }
    }
}
