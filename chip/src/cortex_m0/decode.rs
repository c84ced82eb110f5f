//! The decoder: a table over the top ten bits of a 16-bit instruction (A5.2), filled in when the crate is compiled.

use super::{Core, Outcome};
use super::{
    branch, data_processing, load_store, load_store_multiple, miscellaneous, shift_add, special_data, wide,
};
use crate::bus::Bus;
use crate::report::Fault;

/// Executes one instruction of one kind.
pub(super) type Instruction = fn(&mut Core, &mut Bus, u16) -> Outcome;

/// Instruction by the opcode's bits 15 to 6.
pub(super) static INSTRUCTIONS: [Instruction; 1024] = table();

const fn table() -> [Instruction; 1024] {
    let mut table = [undefined as Instruction; 1024];
    let mut top = 0;
    while top < 1024 {
        table[top as usize] = decode(top);
        top += 1;
    }
    table
}

/// Table A5-1: encoding class by bits 15 to 10.
const fn decode(top: u16) -> Instruction {
    match top >> 4 {
        0b00_0000..=0b00_1111 => shift_add_move_compare(top),
        0b01_0000 => data_processing(top),
        0b01_0001 => special_data_and_branch(top),
        0b01_0010 | 0b01_0011 => load_store::ldr_literal,
        0b01_0100..=0b10_0111 => load_store_single(top),
        0b10_1000 | 0b10_1001 => shift_add::adr,
        0b10_1010 | 0b10_1011 => shift_add::add_sp_immediate_to_register,
        0b10_1100..=0b10_1111 => miscellaneous(top),
        0b11_0000 | 0b11_0001 => load_store_multiple::stm,
        0b11_0010 | 0b11_0011 => load_store_multiple::ldm,
        0b11_0100..=0b11_0111 => conditional_branch(top),
        0b11_1000 | 0b11_1001 => branch::b,
        0b11_1100 | 0b11_1101 => wide::wide,
        _ => undefined,
    }
}

/// A5.2.1.
const fn shift_add_move_compare(top: u16) -> Instruction {
    match top >> 3 & 0b11111 {
        0b00000..=0b00011 => shift_add::lsl_immediate,
        0b00100..=0b00111 => shift_add::lsr_immediate,
        0b01000..=0b01011 => shift_add::asr_immediate,
        0b01100 => shift_add::add_register,
        0b01101 => shift_add::sub_register,
        0b01110 => shift_add::add_immediate_3,
        0b01111 => shift_add::sub_immediate_3,
        0b10000..=0b10011 => shift_add::mov_immediate,
        0b10100..=0b10111 => shift_add::cmp_immediate,
        0b11000..=0b11011 => shift_add::add_immediate_8,
        _ => shift_add::sub_immediate_8,
    }
}

/// A5.2.2: bits 9 to 6.
const fn data_processing(top: u16) -> Instruction {
    match top & 0b1111 {
        0b0000 => data_processing::and,
        0b0001 => data_processing::eor,
        0b0010 => data_processing::lsl,
        0b0011 => data_processing::lsr,
        0b0100 => data_processing::asr,
        0b0101 => data_processing::adc,
        0b0110 => data_processing::sbc,
        0b0111 => data_processing::ror,
        0b1000 => data_processing::tst,
        0b1001 => data_processing::rsb,
        0b1010 => data_processing::cmp,
        0b1011 => data_processing::cmn,
        0b1100 => data_processing::orr,
        0b1101 => data_processing::mul,
        0b1110 => data_processing::bic,
        _ => data_processing::mvn,
    }
}

/// A5.2.3: bits 9 to 6.
const fn special_data_and_branch(top: u16) -> Instruction {
    match top & 0b1111 {
        0b0000..=0b0011 => special_data::add,
        0b0100..=0b0111 => special_data::cmp,
        0b1000..=0b1011 => special_data::mov,
        0b1100 | 0b1101 => special_data::bx,
        _ => special_data::blx,
    }
}

/// A5.2.4: bits 15 to 9.
const fn load_store_single(top: u16) -> Instruction {
    match top >> 3 {
        0b010_1000 => load_store::str_register,
        0b010_1001 => load_store::strh_register,
        0b010_1010 => load_store::strb_register,
        0b010_1011 => load_store::ldrsb_register,
        0b010_1100 => load_store::ldr_register,
        0b010_1101 => load_store::ldrh_register,
        0b010_1110 => load_store::ldrb_register,
        0b010_1111 => load_store::ldrsh_register,
        0b011_0000..=0b011_0011 => load_store::str_immediate,
        0b011_0100..=0b011_0111 => load_store::ldr_immediate,
        0b011_1000..=0b011_1011 => load_store::strb_immediate,
        0b011_1100..=0b011_1111 => load_store::ldrb_immediate,
        0b100_0000..=0b100_0011 => load_store::strh_immediate,
        0b100_0100..=0b100_0111 => load_store::ldrh_immediate,
        0b100_1000..=0b100_1011 => load_store::str_sp,
        _ => load_store::ldr_sp,
    }
}

/// A5.2.5: bits 11 to 6.
const fn miscellaneous(top: u16) -> Instruction {
    match top & 0b11_1111 {
        0b00_0000 | 0b00_0001 => miscellaneous::add_sp_immediate,
        0b00_0010 | 0b00_0011 => miscellaneous::sub_sp_immediate,
        0b00_1000 => miscellaneous::sxth,
        0b00_1001 => miscellaneous::sxtb,
        0b00_1010 => miscellaneous::uxth,
        0b00_1011 => miscellaneous::uxtb,
        0b01_0000..=0b01_0111 => load_store_multiple::push,
        0b01_1001 => miscellaneous::cps,
        0b10_1000 => miscellaneous::rev,
        0b10_1001 => miscellaneous::rev16,
        0b10_1011 => miscellaneous::revsh,
        0b11_0000..=0b11_0111 => load_store_multiple::pop,
        0b11_1000..=0b11_1011 => miscellaneous::bkpt,
        0b11_1100..=0b11_1111 => miscellaneous::hint,
        _ => undefined,
    }
}

/// A5.2.6: the condition is in bits 11 to 8.
const fn conditional_branch(top: u16) -> Instruction {
    match top >> 2 & 0b1111 {
        0b1110 => undefined,
        0b1111 => branch::svc,
        _ => branch::b_conditional,
    }
}

/// Everything ARMv6-M leaves undefined, and `UDF`.
pub(super) fn undefined(_: &mut Core, _: &mut Bus, _: u16) -> Outcome {
    Err(Fault::UndefinedInstruction)
}
