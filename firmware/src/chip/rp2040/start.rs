//! The first instructions after a reset: valve pins high, crystal on.
//!
//! cortex-m-rt calls `__pre_init` first. embassy-rp has one, which only matters for programs that
//! use its spinlock and core 1; `build.rs` has the linker call this one instead. It goes on with
//! the [boot stage](super::boot) and never returns: what would follow is for programs that are
//! linked to one place in flash.
//!
//! At 6.5 MHz and with an empty cache every word of it takes 8 us to come from flash. Therefore the
//! pins come first, and then twice the frequency. The crystal needs 128 ms from then on, which is
//! more than copying and checking a program.

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

/// The ring oscillator divided by 6, not 16 as after a reset: 17 MHz nominally, at most 32. The
/// divisor may be changed while it is used (datasheet 2.17.5). Embassy sets it back when the
/// crystal runs.
const ROSC_DIV: u32 = 0xaa0 + 6;

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
    // ROSC: DIV.
    "ldr r0, =0x40060010",
    "ldr r1, ={rosc_div}",
    "str r1, [r0]",
    // VTOR: a fault from here on vents.
    "ldr r0, =0xe000ed08",
    "ldr r1, =BOOT_VECTORS",
    "str r1, [r0]",
    "ldr r0, =choose_program",
    "bx r0",
    ".pool",
    ".size __wrap___pre_init, . - __wrap___pre_init",
    valve_pins = const VALVE_PINS,
    resets = const IO_BANK0_AND_PADS_BANK0,
    function_sio = const FUNCTION_SIO,
    xosc_startup = const XOSC_STARTUP,
    xosc_control = const XOSC_CONTROL,
    rosc_div = const ROSC_DIV,
);

/// Waits for the crystal.
pub fn wait_for_crystal() {
    while !pac::XOSC.status().read().stable() {}
}
