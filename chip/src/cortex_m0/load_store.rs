//! Loads and stores of one register (A5.2.4), and the data access itself.
//!
//! Two cycles each, one at the single-cycle IO port (SIO), plus what the APB bridge adds (datasheet
//! 2.1.3).

use super::{Core, Outcome, SP, low};
use crate::bus::{Bus, RAM_CYCLES, access_cycles};
use crate::report::Fault;

/// The private peripheral bus: NVIC, SysTick, system control.
fn is_private(address: u32) -> bool {
    address >> 28 == 0xe
}

impl Core {
    /// A word from anywhere. A call, so that what is seldom needed does not stand in the loop over
    /// instructions.
    #[inline(never)]
    pub(super) fn load_word(&mut self, bus: &mut Bus, address: u32) -> Result<u32, Fault> {
        if is_private(address) { self.read_system_control(bus, address) } else { bus.read32(address) }
    }

    #[inline]
    pub(super) fn store_word(&mut self, bus: &mut Bus, address: u32, value: u32) -> Result<(), Fault> {
        if is_private(address) {
            self.write_system_control(bus, address, value)
        } else {
            bus.write32(address, value)
        }
    }

    /// A word from anywhere, with the cycles that it takes. A call, too, unlike what is in SRAM.
    #[inline(never)]
    fn load_word_elsewhere(&mut self, bus: &mut Bus, register: usize, address: u32) -> Outcome {
        self.r[register] = self.load_word(bus, address)?;
        Ok(access_cycles(address, false))
    }

    #[inline(never)]
    fn store_word_elsewhere(&mut self, bus: &mut Bus, register: usize, address: u32) -> Outcome {
        self.store_word(bus, address, self.r[register])?;
        Ok(access_cycles(address, true))
    }
}

/// `[Rn, Rm]`.
#[inline]
fn register_offset(core: &Core, opcode: u16) -> u32 {
    core.r[low(opcode, 3)].wrapping_add(core.r[low(opcode, 6)])
}

/// `[Rn, #imm5 * scale]`.
#[inline]
fn immediate_offset(core: &Core, opcode: u16, scale: u32) -> u32 {
    core.r[low(opcode, 3)].wrapping_add(scale * u32::from(opcode >> 6 & 31))
}

/// `[SP, #imm8 * 4]`.
#[inline]
fn stack_offset(core: &Core, opcode: u16) -> u32 {
    core.r[SP].wrapping_add(4 * u32::from(opcode & 255))
}

#[inline]
fn load32(core: &mut Core, bus: &mut Bus, register: usize, address: u32) -> Outcome {
    match bus.aligned_sram(address) {
        Some(bytes) => {
            core.r[register] = u32::from_le_bytes(bytes);
            Ok(RAM_CYCLES)
        }
        None => core.load_word_elsewhere(bus, register, address),
    }
}

#[inline]
fn store32(core: &mut Core, bus: &mut Bus, register: usize, address: u32) -> Outcome {
    if bus.set_aligned_sram(address, core.r[register].to_le_bytes()) {
        return Ok(RAM_CYCLES);
    }
    core.store_word_elsewhere(bus, register, address)
}

#[inline]
pub(super) fn ldr_literal(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = (core.pc_operand() & !3).wrapping_add(4 * u32::from(opcode & 255));
    load32(core, bus, low(opcode, 8), address)
}

#[inline]
pub(super) fn str_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    store32(core, bus, low(opcode, 0), address)
}

#[inline]
pub(super) fn ldr_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    load32(core, bus, low(opcode, 0), address)
}

#[inline]
pub(super) fn str_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 4);
    store32(core, bus, low(opcode, 0), address)
}

#[inline]
pub(super) fn ldr_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 4);
    load32(core, bus, low(opcode, 0), address)
}

#[inline]
pub(super) fn str_sp(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = stack_offset(core, opcode);
    store32(core, bus, low(opcode, 8), address)
}

#[inline]
pub(super) fn ldr_sp(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = stack_offset(core, opcode);
    load32(core, bus, low(opcode, 8), address)
}

#[inline]
fn store16(core: &mut Core, bus: &mut Bus, opcode: u16, address: u32) -> Outcome {
    bus.write16(address, core.r[low(opcode, 0)] as u16)?;
    Ok(access_cycles(address, true))
}

#[inline]
fn store8(core: &mut Core, bus: &mut Bus, opcode: u16, address: u32) -> Outcome {
    bus.write8(address, core.r[low(opcode, 0)] as u8)?;
    Ok(access_cycles(address, true))
}

#[inline]
pub(super) fn strh_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    store16(core, bus, opcode, address)
}

#[inline]
pub(super) fn strh_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 2);
    store16(core, bus, opcode, address)
}

#[inline]
pub(super) fn strb_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    store8(core, bus, opcode, address)
}

#[inline]
pub(super) fn strb_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 1);
    store8(core, bus, opcode, address)
}

#[inline]
pub(super) fn ldrh_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    core.r[low(opcode, 0)] = u32::from(bus.read16(address)?);
    Ok(access_cycles(address, false))
}

#[inline]
pub(super) fn ldrh_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 2);
    core.r[low(opcode, 0)] = u32::from(bus.read16(address)?);
    Ok(access_cycles(address, false))
}

#[inline]
pub(super) fn ldrb_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    core.r[low(opcode, 0)] = u32::from(bus.read8(address)?);
    Ok(access_cycles(address, false))
}

#[inline]
pub(super) fn ldrb_immediate(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = immediate_offset(core, opcode, 1);
    core.r[low(opcode, 0)] = u32::from(bus.read8(address)?);
    Ok(access_cycles(address, false))
}

#[inline]
pub(super) fn ldrsh_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    core.r[low(opcode, 0)] = i32::from(bus.read16(address)?.cast_signed()).cast_unsigned();
    Ok(access_cycles(address, false))
}

#[inline]
pub(super) fn ldrsb_register(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let address = register_offset(core, opcode);
    core.r[low(opcode, 0)] = i32::from(bus.read8(address)?.cast_signed()).cast_unsigned();
    Ok(access_cycles(address, false))
}
