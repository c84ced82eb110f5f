//! Adapters that hold bytes back to send fewer USB packets.

use std::fs;
use std::path::{Path, PathBuf};

/// FTDI adapters wait up to this long (ms) for more bytes; 1 ms is the least they can be told. The
/// kernel's default is 16.
const LATENCY_TIMER_MS: u32 = 1;

/// Asks the adapter behind `port` to pass bytes on at once, and says in the log what came of it.
///
/// The kernel's own flag for this, `ASYNC_LOW_LATENCY` (ioctl `TIOCSSERIAL`), has no safe interface
/// in the crates used here and this workspace has no `unsafe`; for FTDI adapters, the only common
/// ones that hold bytes back for ms, the driver offers the same setting as a file.
/// `setserial PORT low_latency` sets the flag for others.
pub(super) fn request(port: &Path) {
    let Some(timer) = latency_timer(port) else {
        log::debug!("{}: the driver offers no latency timer; nothing to set", port.display());
        return;
    };
    let now = fs::read_to_string(&timer).ok().and_then(|text| text.trim().parse::<u32>().ok());
    if now.is_some_and(|ms| ms <= LATENCY_TIMER_MS) {
        return;
    }
    match fs::write(&timer, LATENCY_TIMER_MS.to_string()) {
        Ok(()) => log::info!("{}: latency timer set to {LATENCY_TIMER_MS} ms", port.display()),
        Err(error) => log::warn!(
            "{}: the adapter holds bytes back for up to {} ms and may not be told otherwise ({error}); \
             run once: echo {LATENCY_TIMER_MS} | sudo tee {}",
            port.display(),
            now.map_or_else(|| "16".into(), |ms| ms.to_string()),
            timer.display()
        ),
    }
}

/// The driver's file for the latency timer, where there is one.
fn latency_timer(port: &Path) -> Option<PathBuf> {
    let device = fs::canonicalize(port).ok()?;
    let timer = Path::new("/sys/class/tty").join(device.file_name()?).join("device/latency_timer");
    timer.exists().then_some(timer)
}
