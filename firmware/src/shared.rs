//! The board, shared between the bus interrupt and the control loop.

use core::cell::RefCell;
use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_time::Instant;
use pneudrive_control::{Board, Liveness, Micros};

/// What the parts of the firmware share.
pub struct Shared {
    /// All behaviour.
    pub board: Board,
    /// What the watchdog hangs on.
    pub liveness: Liveness,
}

static SHARED: CriticalSectionMutex<RefCell<Option<Shared>>> = CriticalSectionMutex::new(RefCell::new(None));

/// Makes the board available to [`with`].
pub fn install(board: Board) {
    SHARED.lock(|cell| cell.replace(Some(Shared { board, liveness: Liveness::new() })));
}

/// Does something with the board while nobody else does.
pub fn with<R>(action: impl FnOnce(&mut Shared) -> R) -> R {
    SHARED.lock(|cell| match cell.borrow_mut().as_mut() {
        Some(shared) => action(shared),
        None => defmt::unreachable!("used before `install`"),
    })
}

/// The board's clock.
pub fn now() -> Micros {
    Micros::new(Instant::now().as_micros())
}
