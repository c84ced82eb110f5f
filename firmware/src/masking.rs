//! Critical sections that do not make the bus wait.
//!
//! Embassy, the log and `portable-atomic` take critical sections everywhere; a line of log alone
//! holds one for some 20 us, and an answer must be on the wire after 20 us. So what
//! `critical_section` masks here is every interrupt except the bus's two, which therefore must not
//! use anything that relies on it: no waking of tasks, no logging. They share data with the rest
//! through [`shared`](crate::shared), which masks all interrupts, for about a microsecond.
//!
//! Nothing in a signature says so, since any function of another crate may take a critical section.
//! So entering one looks at the interrupt being handled: in a bus interrupt the board stops, at the
//! first test that reaches the place.

use crate::{chip, safe_state};
use core::sync::atomic::{Ordering, compiler_fence};
use critical_section::{Impl, RawRestoreState, set_impl};
use pneudrive_protocol::pages::StopCause;

struct AllButTheBus;
set_impl!(AllButTheBus);

// SAFETY: one core is used, and no code that runs in the bus's interrupts gets into a critical
// section; every other interrupt is masked until the outermost section is left.
unsafe impl Impl for AllButTheBus {
    unsafe fn acquire() -> RawRestoreState {
        if chip::in_bus_interrupt() {
            taken_in_a_bus_interrupt();
        }
        let masked = chip::mask_all_but_the_bus();
        compiler_fence(Ordering::SeqCst);
        masked
    }

    unsafe fn release(masked: RawRestoreState) {
        compiler_fence(Ordering::SeqCst);
        // SAFETY: unmasks what the matching `acquire` has masked.
        unsafe { chip::unmask(masked) };
    }
}

#[cold]
#[inline(never)]
fn taken_in_a_bus_interrupt() -> ! {
    safe_state::stop(StopCause::panic(file!(), line!()))
}
