//! Data processing on two low registers (A5.2.2). `d` is destination and first operand, `m` the second.

use super::{Core, Outcome, low};
use crate::bus::Bus;

/// First and second operand.
#[inline]
fn operands(core: &Core, opcode: u16) -> (u32, u32) {
    (core.r[low(opcode, 0)], core.r[low(opcode, 3)])
}

pub(super) fn and(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a & b);
    Ok(1)
}

pub(super) fn eor(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a ^ b);
    Ok(1)
}

pub(super) fn lsl(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_left(a, b & 255);
    Ok(1)
}

pub(super) fn lsr(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_right(a, b & 255);
    Ok(1)
}

pub(super) fn asr(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.shift_right_arithmetic(a, b & 255);
    Ok(1)
}

pub(super) fn adc(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(a, b, core.flags.c);
    Ok(1)
}

pub(super) fn sbc(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(a, !b, core.flags.c);
    Ok(1)
}

pub(super) fn ror(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.rotate_right(a, b & 255);
    Ok(1)
}

pub(super) fn tst(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.set_nz(a & b);
    Ok(1)
}

/// `RSBS Rd, Rn, #0`: negate.
pub(super) fn rsb(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (_, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.add_with_carry(!b, 0, true);
    Ok(1)
}

pub(super) fn cmp(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.add_with_carry(a, !b, true);
    Ok(1)
}

pub(super) fn cmn(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.add_with_carry(a, b, false);
    Ok(1)
}

pub(super) fn orr(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a | b);
    Ok(1)
}

/// `MULS`: the RP2040 has the single-cycle multiplier (datasheet 2.4.1).
pub(super) fn mul(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a.wrapping_mul(b));
    Ok(1)
}

pub(super) fn bic(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (a, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(a & !b);
    Ok(1)
}

pub(super) fn mvn(core: &mut Core, _: &mut Bus, opcode: u16) -> Outcome {
    let (_, b) = operands(core, opcode);
    core.r[low(opcode, 0)] = core.set_nz(!b);
    Ok(1)
}
