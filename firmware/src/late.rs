//! Code that gets to RAM after the clocks run, instead of before.
//!
//! Start-up copies what the linker script calls `.ram_code` at 6.5 MHz, at 2 us a byte, while the crystal starts. What would make that
//! take longer than the crystal is copied here at 125 MHz, at 0.1 us a byte (`.late_code` in `ram.x`): the board's behaviour and the sensors
//! on the I2C connector. Until then it must not be called.

use core::future::poll_fn;
use core::pin::{Pin, pin};
use core::task::{Context, Poll};

unsafe extern "C" {
    static mut __slate_code: u32;
    static mut __elate_code: u32;
    static __silate_code: u32;
}

/// Copies the code.
///
/// # Safety
/// Called once, before anything that is in it.
pub unsafe fn copy() {
    let (start, end) = (&raw mut __slate_code, &raw mut __elate_code);
    let from = &raw const __silate_code;
    let words = (end as usize - start as usize) / size_of::<u32>();
    for word in 0..words {
        // SAFETY: the linker gives both places this many words, and nothing else is where they go to. Volatile, so that it stays a loop of
        // words and does not become a call of something in flash.
        unsafe { start.add(word).write_volatile(from.add(word).read_volatile()) };
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Runs a future whose code is copied late. What the compiler makes of it would be part of its task else, which has no name that a linker
/// script could tell from other tasks'.
pub async fn run<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    poll_fn(|context| poll(future.as_mut(), context)).await
}

#[inline(never)]
#[unsafe(link_section = ".late_code")]
fn poll<F: Future>(future: Pin<&mut F>, context: &mut Context<'_>) -> Poll<F::Output> {
    future.poll(context)
}
