//! Data processing on two low registers (A5.2.2). `d` is destination and first operand, `m` the
//! second.

use super::{Core, Outcome, low};

/// First and second operand.
#[inline]
fn operands(core: &Core, opcode: u16) -> (u32, u32) {
    (core.r[low(opcode, 0)], core.r[low(opcode, 3)])
}

#[inline]
pub(super) fn and(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a & b);
    Ok(1)
}

#[inline]
pub(super) fn eor(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a ^ b);
    Ok(1)
}

#[inline]
pub(super) fn lsl(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_left(a, b & 255);
    Ok(1)
}

#[inline]
pub(super) fn lsr(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_right(a, b & 255);
    Ok(1)
}

#[inline]
pub(super) fn asr(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_right_arithmetic(a, b & 255);
    Ok(1)
}

#[inline]
pub(super) fn adc(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(a, b, core.flags.c);
    Ok(1)
}

#[inline]
pub(super) fn sbc(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(a, !b, core.flags.c);
    Ok(1)
}

#[inline]
pub(super) fn ror(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.rotate_right(a, b & 255);
    Ok(1)
}

#[inline]
pub(super) fn tst(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.set_nz(a & b);
    Ok(1)
}

/// `RSBS Rd, Rn, #0`: negate.
#[inline]
pub(super) fn rsb(core: &mut Core, opcode: u16) -> Outcome {
    let (_, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(!b, 0, true);
    Ok(1)
}

#[inline]
pub(super) fn cmp(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.add_with_carry(a, !b, true);
    Ok(1)
}

#[inline]
pub(super) fn cmn(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.add_with_carry(a, b, false);
    Ok(1)
}

#[inline]
pub(super) fn orr(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a | b);
    Ok(1)
}

/// `MULS`: the RP2040 has the single-cycle multiplier (datasheet 2.4.1).
#[inline]
pub(super) fn mul(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a.wrapping_mul(b));
    Ok(1)
}

#[inline]
pub(super) fn bic(core: &mut Core, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a & !b);
    Ok(1)
}

#[inline]
pub(super) fn mvn(core: &mut Core, opcode: u16) -> Outcome {
    let (_, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(!b);
    Ok(1)
}
