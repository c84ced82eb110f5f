//! PUSH, POP, STM and LDM. 1 + N cycles for N registers, two more when POP loads the PC (TRM table
//! 3-1).

use super::{Core, LR, Outcome, SP, low};
use crate::bus::Bus;
use crate::report::Fault;

impl Core {
    /// Stores the low registers of `list` at rising addresses; returns the address after the last
    /// one.
    fn store_low_registers(&mut self, bus: &mut Bus, list: u16, mut address: u32) -> Result<u32, Fault> {
        for register in registers(list) {
            if !bus.set_aligned_sram(address, self.r[register].to_le_bytes()) {
                self.store_word(bus, address, self.r[register])?;
            }
            address = address.wrapping_add(4);
        }
        Ok(address)
    }

    /// Loads the low registers of `list` from rising addresses; returns the address after the last
    /// one.
    fn load_low_registers(&mut self, bus: &mut Bus, list: u16, mut address: u32) -> Result<u32, Fault> {
        for register in registers(list) {
            self.r[register] = match bus.aligned_sram(address) {
                Some(bytes) => u32::from_le_bytes(bytes),
                None => self.load_word(bus, address)?,
            };
            address = address.wrapping_add(4);
        }
        Ok(address)
    }
}

/// The numbers of the low registers in a list, rising.
fn registers(list: u16) -> impl Iterator<Item = usize> {
    let mut left = u32::from(list & 0xff);
    std::iter::from_fn(move || {
        let register = left.trailing_zeros();
        left &= left.wrapping_sub(1);
        (register < 8).then_some(register as usize)
    })
}

pub(super) fn push(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let count = (opcode & 0x1ff).count_ones();
    let bottom = core.r[SP].wrapping_sub(4 * count);
    let address = core.store_low_registers(bus, opcode, bottom)?;
    if opcode >> 8 & 1 != 0 {
        core.store_word(bus, address, core.r[LR])?;
    }
    core.set_sp(bottom);
    Ok(1 + count)
}

pub(super) fn pop(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let count = (opcode & 0x1ff).count_ones();
    let address = core.load_low_registers(bus, opcode, core.r[SP])?;
    if opcode >> 8 & 1 == 0 {
        core.set_sp(address);
        return Ok(1 + count);
    }
    let target = core.load_word(bus, address)?;
    core.set_sp(address.wrapping_add(4));
    core.branch_exchange(bus, target)?;
    Ok(3 + count)
}

pub(super) fn stm(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let base = low(opcode, 8);
    core.r[base] = core.store_low_registers(bus, opcode, core.r[base])?;
    Ok(1 + (opcode & 0xff).count_ones())
}

/// `LDM`: a base register that is in the list keeps the loaded value.
pub(super) fn ldm(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    let base = low(opcode, 8);
    let end = core.load_low_registers(bus, opcode, core.r[base])?;
    if opcode >> base & 1 == 0 {
        core.r[base] = end;
    }
    Ok(1 + (opcode & 0xff).count_ones())
}
