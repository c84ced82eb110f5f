use crate::failure::Failure;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C, SIGTERM or SIGHUP.
#[derive(Debug, Clone)]
pub struct StopSignal(Arc<AtomicBool>);

impl StopSignal {
    /// A second Ctrl-C or SIGTERM ends the process at once, in case something hangs. SIGHUP never
    /// does: a terminal that closes may send several, and the boards shall be vented. With
    /// `keep_running` it is ignored.
    pub fn install(keep_running: bool) -> Result<Self, Failure> {
        let (stop, asked) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let ignored = Arc::default();
        let install = || {
            for signal in [SIGINT, SIGTERM] {
                // The order matters: the first signal finds the flag unset.
                flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&asked))?;
                flag::register(signal, Arc::clone(&asked))?;
                flag::register(signal, Arc::clone(&stop))?;
            }
            flag::register(SIGHUP, if keep_running { ignored } else { Arc::clone(&stop) })
        };
        install().map_err(|error| Failure::running(format!("cannot handle signals: {error}")))?;
        Ok(Self(stop))
    }

    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
