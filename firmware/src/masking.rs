//! Critical sections that do not make the bus wait.
//!
//! Embassy, the log and `portable-atomic` take critical sections everywhere; a line of log alone holds one for some 20 us,
//! and an answer must be on the wire after 20 us. So what `critical_section` masks here is every interrupt except
//! the bus's two, which therefore must not use anything that relies on it: no waking of tasks, no logging. They share data
//! with the rest through [`shared`](crate::shared), which masks all interrupts, for about a microsecond.

use crate::chip;
use core::sync::atomic::{Ordering, compiler_fence};
use critical_section::{Impl, RawRestoreState, set_impl};

struct AllButTheBus;
set_impl!(AllButTheBus);

// SAFETY: one core is used, and no code that runs in the bus's interrupts enters a critical section; every other
// interrupt is masked until the outermost section is left.
unsafe impl Impl for AllButTheBus {
    unsafe fn acquire() -> RawRestoreState {
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
