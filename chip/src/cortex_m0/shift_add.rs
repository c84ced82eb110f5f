//! Shift (immediate), add, subtract, move and compare (A5.2.1), and the two address additions of
//! table A5-1.

use super::{Core, Outcome, SP, low};

/// The 5-bit shift amount in bits 10 to 6.
#[inline]
fn shift_amount(opcode: u16) -> u32 {
    u32::from(opcode >> 6 & 31)
}

/// The 8-bit immediate in the low byte.
#[inline]
fn immediate_8(opcode: u16) -> u32 {
    u32::from(opcode & 255)
}

#[inline]
pub(super) fn lsl_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.shift_left(core.r[low(opcode, 3)], shift_amount(opcode));
    Ok(1)
}

#[inline]
pub(super) fn lsr_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.shift_right(core.r[low(opcode, 3)], zero_means_32(shift_amount(opcode)));
    Ok(1)
}

#[inline]
pub(super) fn asr_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] =
        core.shift_right_arithmetic(core.r[low(opcode, 3)], zero_means_32(shift_amount(opcode)));
    Ok(1)
}

/// The encoding of a right shift by 32 (A6.7.36).
#[inline]
fn zero_means_32(amount: u32) -> u32 {
    if amount == 0 { 32 } else { amount }
}

#[inline]
pub(super) fn add_register(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.add_with_carry(core.r[low(opcode, 3)], core.r[low(opcode, 6)], false);
    Ok(1)
}

#[inline]
pub(super) fn sub_register(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.add_with_carry(core.r[low(opcode, 3)], !core.r[low(opcode, 6)], true);
    Ok(1)
}

#[inline]
pub(super) fn add_immediate_3(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.add_with_carry(core.r[low(opcode, 3)], u32::from(opcode >> 6 & 7), false);
    Ok(1)
}

#[inline]
pub(super) fn sub_immediate_3(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.add_with_carry(core.r[low(opcode, 3)], !u32::from(opcode >> 6 & 7), true);
    Ok(1)
}

#[inline]
pub(super) fn mov_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 8)] = core.set_nz(immediate_8(opcode));
    Ok(1)
}

#[inline]
pub(super) fn cmp_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.add_with_carry(core.r[low(opcode, 8)], !immediate_8(opcode), true);
    Ok(1)
}

#[inline]
pub(super) fn add_immediate_8(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 8)] = core.add_with_carry(core.r[low(opcode, 8)], immediate_8(opcode), false);
    Ok(1)
}

#[inline]
pub(super) fn sub_immediate_8(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 8)] = core.add_with_carry(core.r[low(opcode, 8)], !immediate_8(opcode), true);
    Ok(1)
}

/// `ADR`: the word-aligned PC plus four times the immediate.
#[inline]
pub(super) fn adr(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 8)] = (core.pc_operand() & !3).wrapping_add(4 * immediate_8(opcode));
    Ok(1)
}

/// `ADD Rd, SP, #imm`.
#[inline]
pub(super) fn add_sp_immediate_to_register(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 8)] = core.r[SP].wrapping_add(4 * immediate_8(opcode));
    Ok(1)
}
