//! Miscellaneous 16-bit instructions (A5.2.5): stack adjustment, extension, byte reversal, CPS,
//! hints.

use super::{Activity, Core, Outcome, SP, low};
use crate::bus::Bus;
use crate::report::Fault;

#[inline]
pub(super) fn add_sp_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.set_sp(core.r[SP].wrapping_add(4 * u32::from(opcode & 127)));
    Ok(1)
}

#[inline]
pub(super) fn sub_sp_immediate(core: &mut Core, opcode: u16) -> Outcome {
    core.set_sp(core.r[SP].wrapping_sub(4 * u32::from(opcode & 127)));
    Ok(1)
}

#[inline]
pub(super) fn sxth(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)] as i16 as u32;
    Ok(1)
}

#[inline]
pub(super) fn sxtb(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)] as i8 as u32;
    Ok(1)
}

#[inline]
pub(super) fn uxth(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)] & 0xffff;
    Ok(1)
}

#[inline]
pub(super) fn uxtb(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)] & 0xff;
    Ok(1)
}

#[inline]
pub(super) fn rev(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)].swap_bytes();
    Ok(1)
}

#[inline]
pub(super) fn rev16(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = core.r[low(opcode, 3)].swap_bytes().rotate_left(16);
    Ok(1)
}

#[inline]
pub(super) fn revsh(core: &mut Core, opcode: u16) -> Outcome {
    core.r[low(opcode, 0)] = (core.r[low(opcode, 3)] as u16).swap_bytes() as i16 as u32;
    Ok(1)
}

/// `CPSIE i` and `CPSID i`. The core is always privileged: the RP2040's user mode is not modelled.
pub(super) fn cps(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    match opcode {
        0xb662 => core.primask = false,
        0xb672 => core.primask = true,
        _ => return Err(Fault::UndefinedInstruction),
    }
    bus.notice_interrupts();
    Ok(1)
}

/// `BKPT`: a HardFault, unless a debugger is attached (C1.5).
pub(super) fn bkpt(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    if !core.debugger_attached {
        return Err(Fault::Breakpoint);
    }
    core.breakpoint = opcode as u8;
    core.sleep(bus, Activity::Halted);
    Ok(1)
}

/// `NOP`, `YIELD`, `WFE`, `WFI`, `SEV`; the rest of the hint space executes as `NOP` (A5.2.5, table
/// A5-7).
pub(super) fn hint(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    match opcode & 0xff {
        0x20 => {
            if core.event_register {
                core.event_register = false;
            } else {
                core.sleep(bus, Activity::WaitingForEvent);
            }
            Ok(2)
        }
        0x30 => {
            core.sleep(bus, Activity::WaitingForInterrupt);
            Ok(2)
        }
        0x40 => {
            core.event_register = true;
            bus.notice_interrupts();
            Ok(1)
        }
        hint if hint & 0x0f != 0 => Err(Fault::UndefinedInstruction),
        _ => Ok(1),
    }
}
