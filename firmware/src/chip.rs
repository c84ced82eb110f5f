//! What differs between the RP2040 and the RP2350.

#[cfg(feature = "rp2040")]
mod rp2040;
#[cfg(feature = "rp2350")]
mod rp2350;

#[cfg(feature = "rp2040")]
pub use rp2040::*;
#[cfg(feature = "rp2350")]
pub use rp2350::*;

/// Number of the exception being handled (IPSR): 16 and more are interrupts. In assembly, because
/// every critical section asks for it.
#[inline(always)]
fn active_exception() -> u32 {
    let number: u32;
    // SAFETY: reads a register of the processor.
    unsafe { core::arch::asm!("mrs {}, IPSR", out(reg) number, options(nomem, nostack, preserves_flags)) };
    number
}
