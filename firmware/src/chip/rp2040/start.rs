//! The first instructions after a reset: valve pins high, crystal on.
//!
//! cortex-m-rt calls `__pre_init` before it copies anything to RAM. embassy-rp has one, which only matters for programs that use its
//! spinlock and core 1; `build.rs` has the linker call this one instead. It is in flash and in assembly, because no Rust function
//! and no variable is in its place yet.
//!
//! At 6.5 MHz and with an empty cache every word of it takes 8 us to come from flash. The crystal needs 128 ms from then on,
//! which is more than the copying.

use crate::config::VALVE_PINS;
use embassy_rp::pac;

/// RESETS: the pins' functions and pads.
const IO_BANK0_AND_PADS_BANK0: u32 = 1 << 5 | 1 << 8;
/// FUNCSEL of pins that SIO drives.
const FUNCTION_SIO: u32 = 5;
/// Start-up delay of Embassy's default configuration, 128 ms, in units of 256 crystal cycles.
const XOSC_STARTUP: u32 = 12_000 * 128 / 256;
/// Crystals of 1 to 15 MHz; enabled.
const XOSC_CONTROL: u32 = 0xfab << 12 | 0xaa0;

const _: () = assert!(VALVE_PINS == 0xff << 6, "the code below is for GPIO 6 to 13");
const _: () = assert!(IO_BANK0_AND_PADS_BANK0 == 9 << 5);

core::arch::global_asm!(
    ".section .Reset, \"ax\"",
    ".global __wrap___pre_init",
    ".type __wrap___pre_init,%function",
    ".thumb_func",
    "__wrap___pre_init:",
    // SIO: levels first, then drivers. Shifts where they take less flash than a constant.
    "movs r0, #0xd",
    "lsls r0, r0, #28",
    "movs r1, #{valve_pins} >> 6",
    "lsls r1, r1, #6",
    "str r1, [r0, #0x14]",
    "str r1, [r0, #0x24]",
    // RESETS, alias that clears bits; RESET_DONE.
    "ldr r0, =0x4000f000",
    "movs r1, #{resets} >> 5",
    "lsls r1, r1, #5",
    "str r1, [r0]",
    "0:",
    "ldr r2, [r0, #8]",
    "ands r2, r1",
    "cmp r2, r1",
    "bne 0b",
    // CTRL of GPIO 13 down to 6.
    "ldr r0, =0x40014034",
    "movs r1, #{function_sio}",
    "movs r2, #56",
    "0:",
    "str r1, [r0, r2]",
    "subs r2, #8",
    "bpl 0b",
    // XOSC: STARTUP, CTRL.
    "ldr r0, =0x40024000",
    "ldr r1, ={xosc_startup}",
    "str r1, [r0, #12]",
    "ldr r1, ={xosc_control}",
    "str r1, [r0]",
    "bx lr",
    ".pool",
    ".size __wrap___pre_init, . - __wrap___pre_init",
    valve_pins = const VALVE_PINS,
    resets = const IO_BANK0_AND_PADS_BANK0,
    function_sio = const FUNCTION_SIO,
    xosc_startup = const XOSC_STARTUP,
    xosc_control = const XOSC_CONTROL,
);

/// Waits for the crystal. Embassy would, too, but with the pins in reset.
pub fn wait_for_crystal() {
    while !pac::XOSC.status().read().stable() {}
}
