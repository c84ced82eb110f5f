//! The vector table in RAM: an interrupt whose vector had to come from flash would begin 0.4 us
//! late.

use crate::chip;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::SCB;

/// Sixteen of the processor, and the chip's interrupts.
const VECTORS: usize = 16 + chip::INTERRUPT_LINES;

/// Aligned to a power of two that is not less than its size, as VTOR needs.
#[repr(align(512))]
struct Table([AtomicU32; VECTORS]);

static TABLE: Table = Table([const { AtomicU32::new(0) }; VECTORS]);

/// Copies the table that VTOR points to, and points it to the copy.
///
/// # Safety
/// Called at start-up, while no interrupt is enabled.
pub unsafe fn move_to_ram() {
    // SAFETY: single registers of the system control block, which nobody else uses now.
    let scb = unsafe { &*SCB::PTR };
    let in_flash = scb.vtor.read() as *const u32;
    for (number, vector) in TABLE.0.iter().enumerate() {
        // SAFETY: the table in flash has as many entries, behind them is code that may be read,
        // too.
        vector.store(unsafe { in_flash.add(number).read() }, Ordering::Relaxed);
    }
    cortex_m::asm::dsb();
    // SAFETY: the copy is complete, aligned, and stays.
    unsafe { scb.vtor.write(TABLE.0.as_ptr() as u32) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

const _: () = assert!(size_of::<Table>() == align_of::<Table>());
