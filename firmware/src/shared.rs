//! What the parts of the firmware share: the board's bus side, and what the control loop last did.

use core::cell::RefCell;
use cortex_m::interrupt::{self, CriticalSection, Mutex};
use embassy_time::Instant;
use pneudrive_control::{BoardStatus, BusPort, ControlStatus, Liveness, Micros};

/// Shared between the bus interrupts, the control loop and the supervision.
pub struct Shared {
    /// The board's bus side.
    pub port: BusPort,
    /// What the last control step did.
    pub control: ControlStatus,
    /// What the watchdog hangs on.
    pub liveness: Liveness,
}

impl Shared {
    /// The board at a glance.
    pub fn status(&self) -> BoardStatus {
        BoardStatus::new(&self.port, self.control)
    }
}

static SHARED: Mutex<RefCell<Option<Shared>>> = Mutex::new(RefCell::new(None));

/// Makes the board available to [`with`].
pub fn install(port: BusPort, control: ControlStatus) {
    let shared = Shared { port, control, liveness: Liveness::new() };
    interrupt::free(|masked| SHARED.borrow(masked).replace(Some(shared)));
}

/// Does something short with what is shared while all interrupts wait, the bus's included.
pub fn with<R>(action: impl FnOnce(&mut Shared) -> R) -> R {
    interrupt::free(|masked| within(masked, action))
}

/// The same where nothing can interrupt.
pub fn within<R>(masked: &CriticalSection, action: impl FnOnce(&mut Shared) -> R) -> R {
    match SHARED.borrow(masked).borrow_mut().as_mut() {
        Some(shared) => action(shared),
        None => defmt::unreachable!("used before `install`"),
    }
}

/// The board's clock.
pub fn now() -> Micros {
    Micros::new(Instant::now().as_micros())
}
