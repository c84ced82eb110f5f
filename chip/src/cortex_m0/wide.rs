//! The 32-bit instructions of ARMv6-M (A5.3): BL, MSR, MRS and the barriers.

use super::{Core, LR, Outcome, PC};
use crate::bus::Bus;
use crate::report::Fault;

pub(super) fn wide(core: &mut Core, bus: &mut Bus, first: u16) -> Outcome {
    let second = bus.fetch(core.r[PC]).ok_or(Fault::Bus(core.r[PC]))?;
    core.r[PC] = core.r[PC].wrapping_add(2);
    match (first, second) {
        (_, _) if second & 0xd000 == 0xd000 => Ok(branch_with_link(core, first, second)),
        (0xf380..=0xf39f, _) if second & 0xff00 == 0x8800 => {
            core.write_special_register(bus, second & 0xff, core.r[usize::from(first & 15)])?;
            Ok(3)
        }
        (0xf3ef, _) if second & 0xf000 == 0x8000 => {
            core.r[usize::from(second >> 8 & 15)] = core.read_special_register(second & 0xff)?;
            Ok(3)
        }
        // DSB, DMB, ISB: nothing is ever outstanding here.
        (0xf3bf, 0x8f40..=0x8f6f) => Ok(3),
        _ => Err(Fault::UndefinedInstruction),
    }
}

/// `BL`, encoding T1: sign, two inverted bits and 21 bits of offset.
fn branch_with_link(core: &mut Core, first: u16, second: u16) -> u32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let sign = first >> 10 & 1;
    let bit_23 = !(second >> 13 ^ sign) & 1;
    let bit_22 = !(second >> 11 ^ sign) & 1;
    let offset = sign << 24 | bit_23 << 23 | bit_22 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    let offset = (offset << 7).cast_signed() >> 7;
    core.r[LR] = core.r[PC] | 1;
    core.r[PC] = core.r[PC].wrapping_add_signed(offset);
    3
}
