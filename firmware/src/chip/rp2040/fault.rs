//! A HardFault vents from flash, where no stray write to RAM can reach the instructions, and then
//! goes to the program's handler.

use crate::config::VALVE_PINS;

/// Offset of the HardFault's entry in a vector table.
pub const HANDLER: u32 = 4 * 3;
/// Offset of the entry, reserved in ARMv6-M, to which the boot stage moves the program's handler.
pub const PROGRAMS_HANDLER: u32 = 4 * 7;

unsafe extern "C" {
    /// The handler. R0 to R3 and R12 are on the stack, and the others stay as they are for the
    /// program's handler.
    pub fn boot_hard_fault();
}

core::arch::global_asm!(
    ".section .Reset, \"ax\"",
    ".global boot_hard_fault",
    ".type boot_hard_fault,%function",
    ".thumb_func",
    "boot_hard_fault:",
    // SIO: levels first, then drivers.
    "movs r0, #0xd",
    "lsls r0, r0, #28",
    "movs r1, #{valve_pins} >> 6",
    "lsls r1, r1, #6",
    "str r1, [r0, #0x14]",
    "str r1, [r0, #0x24]",
    // CTRL of GPIO 13 down to 6: SIO.
    "ldr r0, =0x40014034",
    "movs r1, #5",
    "movs r2, #56",
    "0:",
    "str r1, [r0, r2]",
    "subs r2, #8",
    "bpl 0b",
    // The program's own, if one runs.
    "ldr r0, =0xe000ed08",
    "ldr r0, [r0]",
    "ldr r0, [r0, #{programs_handler}]",
    "cmp r0, #0",
    "1:",
    "beq 1b",
    "bx r0",
    ".pool",
    ".size boot_hard_fault, . - boot_hard_fault",
    valve_pins = const VALVE_PINS,
    programs_handler = const PROGRAMS_HANDLER,
);

/// The boot stage's own vectors, while no program is in RAM. Aligned as VTOR needs.
#[repr(C, align(256))]
pub struct BootVectors([Option<unsafe extern "C" fn()>; 16]);

/// Named, so that `start.rs` finds it.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".boot_data.vectors")]
pub static BOOT_VECTORS: BootVectors = {
    let mut vectors: [Option<unsafe extern "C" fn()>; 16] = [None; 16];
    vectors[2] = Some(boot_hard_fault);
    vectors[3] = Some(boot_hard_fault);
    BootVectors(vectors)
};
