use rustix::io::Errno;
use thiserror::Error;

/// Something of [`RealTime`](super::RealTime) that cannot be had.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RealTimeError {
    /// The user may not have it.
    #[error(
        "real-time priority {priority}: not permitted; allow it with `@dialout - rtprio 99` in /etc/security/limits.d/pneudrive.conf \
         (then log in again), or with sudo setcap cap_sys_nice,cap_ipc_lock+ep on the program, or run without it"
    )]
    PriorityNotPermitted {
        /// The priority that was asked for.
        priority: u8,
    },
    /// SCHED_FIFO has no such priority.
    #[error("real-time priority {priority}: must be 1 to 99")]
    NoSuchPriority {
        /// The priority that was asked for.
        priority: u8,
    },
    /// More memory than the user may lock.
    #[error(
        "locking memory: not permitted ({reason}); allow it with `@dialout - memlock unlimited` in \
         /etc/security/limits.d/pneudrive.conf (then log in again), or with sudo setcap cap_sys_nice,cap_ipc_lock+ep on the program, \
         or run without it"
    )]
    MemoryNotPermitted {
        /// What the system said.
        reason: String,
    },
    /// The core does not exist, or the process may not use it.
    #[error("core {core}: this process may use the cores {cores:?}, counted from 0")]
    NoSuchCore {
        /// The core that was asked for.
        core: usize,
        /// Those that there are.
        cores: Vec<usize>,
    },
    /// Anything else the system said.
    #[error("real time: {what} cannot be set: {reason}")]
    System {
        /// What was asked for.
        what: &'static str,
        /// What the system said.
        reason: String,
    },
}

impl RealTimeError {
    pub(super) fn system(what: &'static str, errno: Errno) -> Self {
        Self::System { what, reason: errno.to_string() }
    }

    pub(super) fn memory(errno: Errno) -> Self {
        match errno {
            Errno::PERM | Errno::NOMEM | Errno::AGAIN => {
                Self::MemoryNotPermitted { reason: errno.to_string() }
            }
            other => Self::system("locked memory", other),
        }
    }

    pub(super) fn priority(priority: u8, source: &thread_priority::Error) -> Self {
        match source {
            thread_priority::Error::OS(code) if Errno::from_raw_os_error(*code) == Errno::PERM => {
                Self::PriorityNotPermitted { priority }
            }
            thread_priority::Error::PriorityNotInRange(_) => Self::NoSuchPriority { priority },
            other => Self::System { what: "the priority", reason: other.to_string() },
        }
    }
}
