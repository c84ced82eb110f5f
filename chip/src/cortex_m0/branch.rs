//! Branches and SVC (A5.2.6), and BranchTo with interworking.

use super::exceptions::SVCALL;
use super::{Core, Outcome, PC};
use crate::bus::Bus;
use crate::report::Fault;

impl Core {
    /// BXWritePC: in handler mode an EXC_RETURN value returns from the exception, everything else
    /// needs the Thumb bit.
    pub(super) fn branch_exchange(&mut self, bus: &mut Bus, target: u32) -> Result<(), Fault> {
        if self.ipsr != 0 && target >> 28 == 0xf {
            return self.exception_return(bus, target);
        }
        if target & 1 == 0 {
            return Err(Fault::InvalidState);
        }
        self.r[PC] = target & !1;
        Ok(())
    }

    /// ConditionPassed (A6.3): bit 0 inverts, bits 3 to 1 choose.
    #[inline]
    fn condition(&self, condition: u16) -> bool {
        let flags = self.flags;
        let met = match condition >> 1 & 7 {
            0 => flags.z(),
            1 => flags.c,
            2 => flags.n(),
            3 => flags.v(),
            4 => flags.c && !flags.z(),
            5 => flags.n() == flags.v(),
            _ => flags.n() == flags.v() && !flags.z(),
        };
        met != (condition & 1 != 0)
    }
}

/// Two cycles taken, one not taken.
#[inline]
pub(super) fn b_conditional(core: &mut Core, opcode: u16) -> Outcome {
    if !core.condition(opcode >> 8) {
        return Ok(1);
    }
    let offset = 2 * i32::from(opcode as u8 as i8);
    core.r[PC] = core.pc_operand().wrapping_add_signed(offset);
    Ok(2)
}

/// Unconditional, with an 11-bit offset in halfwords.
#[inline]
pub(super) fn b(core: &mut Core, opcode: u16) -> Outcome {
    let offset = i32::from((opcode << 5).cast_signed() >> 4);
    core.r[PC] = core.pc_operand().wrapping_add_signed(offset);
    Ok(2)
}

pub(super) fn svc(core: &mut Core, bus: &mut Bus) -> Outcome {
    core.take_supervisor_call(bus, SVCALL)
}
