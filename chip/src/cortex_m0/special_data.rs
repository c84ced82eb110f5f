//! Special data instructions and branch and exchange (A5.2.3): the ones that reach all sixteen
//! registers.

use super::{Core, LR, Outcome, PC, SP};
use crate::bus::Bus;

/// Destination and first operand: bit 7 above bits 2 to 0.
#[inline]
fn destination(opcode: u16) -> usize {
    usize::from(opcode & 7 | opcode >> 4 & 8)
}

/// Second operand: bits 6 to 3.
#[inline]
fn source(opcode: u16) -> usize {
    usize::from(opcode >> 3 & 15)
}

impl Core {
    fn any_register(&self, number: usize) -> u32 {
        if number == PC { self.pc_operand() } else { self.r[number] }
    }

    /// Writes a result; a write to the PC is a branch and takes a cycle more.
    fn write_any_register(&mut self, number: usize, value: u32) -> u32 {
        match number {
            PC => {
                self.r[PC] = value & !1;
                return 2;
            }
            SP => self.set_sp(value & !3),
            _ => self.r[number] = value,
        }
        1
    }
}

#[inline]
pub(super) fn add(core: &mut Core, opcode: u16) -> Outcome {
    let sum = core.any_register(destination(opcode)).wrapping_add(core.any_register(source(opcode)));
    Ok(core.write_any_register(destination(opcode), sum))
}

#[inline]
pub(super) fn cmp(core: &mut Core, opcode: u16) -> Outcome {
    core.add_with_carry(core.any_register(destination(opcode)), !core.any_register(source(opcode)), true);
    Ok(1)
}

#[inline]
pub(super) fn mov(core: &mut Core, opcode: u16) -> Outcome {
    let value = core.any_register(source(opcode));
    Ok(core.write_any_register(destination(opcode), value))
}

#[inline]
pub(super) fn bx(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    core.branch_exchange(bus, core.any_register(source(opcode)))?;
    Ok(2)
}

#[inline]
pub(super) fn blx(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let target = core.any_register(source(opcode));
    core.r[LR] = core.r[PC] | 1;
    core.branch_exchange(bus, target)?;
    Ok(2)
}
