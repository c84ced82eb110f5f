//! The decoder: a table over the top ten bits of a 16-bit instruction (A5.2), filled in when the crate is compiled, and the jump by
//! what it says. The code of nearly all instructions stands behind that jump itself, without a call.

use super::{Core, Outcome};
use super::{
    branch, data_processing, load_store, load_store_multiple, miscellaneous, shift_add, special_data, wide,
};
use crate::bus::Bus;
use crate::report::Fault;

/// What an instruction is. Numbered without gaps, so that the jump is one through a table.
#[derive(Clone, Copy)]
enum Kind {
    LslImmediate,
    LsrImmediate,
    AsrImmediate,
    AddRegister,
    SubRegister,
    AddImmediate3,
    SubImmediate3,
    MovImmediate,
    CmpImmediate,
    AddImmediate8,
    SubImmediate8,
    And,
    Eor,
    Lsl,
    Lsr,
    Asr,
    Adc,
    Sbc,
    Ror,
    Tst,
    Rsb,
    Cmp,
    Cmn,
    Orr,
    Mul,
    Bic,
    Mvn,
    AddAnyRegister,
    CmpAnyRegister,
    MovAnyRegister,
    Bx,
    Blx,
    LdrLiteral,
    StrRegister,
    StrhRegister,
    StrbRegister,
    LdrsbRegister,
    LdrRegister,
    LdrhRegister,
    LdrbRegister,
    LdrshRegister,
    StrImmediate,
    LdrImmediate,
    StrbImmediate,
    LdrbImmediate,
    StrhImmediate,
    LdrhImmediate,
    StrSp,
    LdrSp,
    Adr,
    AddSpImmediateToRegister,
    AddSpImmediate,
    SubSpImmediate,
    Sxth,
    Sxtb,
    Uxth,
    Uxtb,
    Push,
    Cps,
    Rev,
    Rev16,
    Revsh,
    Pop,
    Bkpt,
    Hint,
    Stm,
    Ldm,
    BConditional,
    Svc,
    B,
    Wide,
    /// Everything ARMv6-M leaves undefined, and `UDF`.
    Undefined,
}

/// Kind by the opcode's bits 15 to 6.
static KINDS: [Kind; 1024] = table();

const fn table() -> [Kind; 1024] {
    let mut table = [Kind::Undefined; 1024];
    let mut top = 0;
    while top < 1024 {
        table[top as usize] = kind(top);
        top += 1;
    }
    table
}

/// Executes one instruction.
#[inline]
pub(super) fn execute(core: &mut Core, bus: &mut Bus, opcode: u16) -> Outcome {
    match KINDS[usize::from(opcode >> 6)] {
        Kind::LslImmediate => shift_add::lsl_immediate(core, opcode),
        Kind::LsrImmediate => shift_add::lsr_immediate(core, opcode),
        Kind::AsrImmediate => shift_add::asr_immediate(core, opcode),
        Kind::AddRegister => shift_add::add_register(core, opcode),
        Kind::SubRegister => shift_add::sub_register(core, opcode),
        Kind::AddImmediate3 => shift_add::add_immediate_3(core, opcode),
        Kind::SubImmediate3 => shift_add::sub_immediate_3(core, opcode),
        Kind::MovImmediate => shift_add::mov_immediate(core, opcode),
        Kind::CmpImmediate => shift_add::cmp_immediate(core, opcode),
        Kind::AddImmediate8 => shift_add::add_immediate_8(core, opcode),
        Kind::SubImmediate8 => shift_add::sub_immediate_8(core, opcode),
        Kind::And => data_processing::and(core, opcode),
        Kind::Eor => data_processing::eor(core, opcode),
        Kind::Lsl => data_processing::lsl(core, opcode),
        Kind::Lsr => data_processing::lsr(core, opcode),
        Kind::Asr => data_processing::asr(core, opcode),
        Kind::Adc => data_processing::adc(core, opcode),
        Kind::Sbc => data_processing::sbc(core, opcode),
        Kind::Ror => data_processing::ror(core, opcode),
        Kind::Tst => data_processing::tst(core, opcode),
        Kind::Rsb => data_processing::rsb(core, opcode),
        Kind::Cmp => data_processing::cmp(core, opcode),
        Kind::Cmn => data_processing::cmn(core, opcode),
        Kind::Orr => data_processing::orr(core, opcode),
        Kind::Mul => data_processing::mul(core, opcode),
        Kind::Bic => data_processing::bic(core, opcode),
        Kind::Mvn => data_processing::mvn(core, opcode),
        Kind::AddAnyRegister => special_data::add(core, opcode),
        Kind::CmpAnyRegister => special_data::cmp(core, opcode),
        Kind::MovAnyRegister => special_data::mov(core, opcode),
        Kind::Bx => special_data::bx(core, bus, opcode),
        Kind::Blx => special_data::blx(core, bus, opcode),
        Kind::LdrLiteral => load_store::ldr_literal(core, bus, opcode),
        Kind::StrRegister => load_store::str_register(core, bus, opcode),
        Kind::StrhRegister => load_store::strh_register(core, bus, opcode),
        Kind::StrbRegister => load_store::strb_register(core, bus, opcode),
        Kind::LdrsbRegister => load_store::ldrsb_register(core, bus, opcode),
        Kind::LdrRegister => load_store::ldr_register(core, bus, opcode),
        Kind::LdrhRegister => load_store::ldrh_register(core, bus, opcode),
        Kind::LdrbRegister => load_store::ldrb_register(core, bus, opcode),
        Kind::LdrshRegister => load_store::ldrsh_register(core, bus, opcode),
        Kind::StrImmediate => load_store::str_immediate(core, bus, opcode),
        Kind::LdrImmediate => load_store::ldr_immediate(core, bus, opcode),
        Kind::StrbImmediate => load_store::strb_immediate(core, bus, opcode),
        Kind::LdrbImmediate => load_store::ldrb_immediate(core, bus, opcode),
        Kind::StrhImmediate => load_store::strh_immediate(core, bus, opcode),
        Kind::LdrhImmediate => load_store::ldrh_immediate(core, bus, opcode),
        Kind::StrSp => load_store::str_sp(core, bus, opcode),
        Kind::LdrSp => load_store::ldr_sp(core, bus, opcode),
        Kind::Adr => shift_add::adr(core, opcode),
        Kind::AddSpImmediateToRegister => shift_add::add_sp_immediate_to_register(core, opcode),
        Kind::AddSpImmediate => miscellaneous::add_sp_immediate(core, opcode),
        Kind::SubSpImmediate => miscellaneous::sub_sp_immediate(core, opcode),
        Kind::Sxth => miscellaneous::sxth(core, opcode),
        Kind::Sxtb => miscellaneous::sxtb(core, opcode),
        Kind::Uxth => miscellaneous::uxth(core, opcode),
        Kind::Uxtb => miscellaneous::uxtb(core, opcode),
        Kind::Push => load_store_multiple::push(core, bus, opcode),
        Kind::Cps => miscellaneous::cps(core, bus, opcode),
        Kind::Rev => miscellaneous::rev(core, opcode),
        Kind::Rev16 => miscellaneous::rev16(core, opcode),
        Kind::Revsh => miscellaneous::revsh(core, opcode),
        Kind::Pop => load_store_multiple::pop(core, bus, opcode),
        Kind::Bkpt => miscellaneous::bkpt(core, bus, opcode),
        Kind::Hint => miscellaneous::hint(core, bus, opcode),
        Kind::Stm => load_store_multiple::stm(core, bus, opcode),
        Kind::Ldm => load_store_multiple::ldm(core, bus, opcode),
        Kind::BConditional => branch::b_conditional(core, opcode),
        Kind::Svc => branch::svc(core, bus),
        Kind::B => branch::b(core, opcode),
        Kind::Wide => wide::wide(core, bus, opcode),
        Kind::Undefined => Err(Fault::UndefinedInstruction),
    }
}

/// Table A5-1: encoding class by bits 15 to 10.
const fn kind(top: u16) -> Kind {
    match top >> 4 {
        0b00_0000..=0b00_1111 => shift_add_move_compare(top),
        0b01_0000 => data_processing(top),
        0b01_0001 => special_data_and_branch(top),
        0b01_0010 | 0b01_0011 => Kind::LdrLiteral,
        0b01_0100..=0b10_0111 => load_store_single(top),
        0b10_1000 | 0b10_1001 => Kind::Adr,
        0b10_1010 | 0b10_1011 => Kind::AddSpImmediateToRegister,
        0b10_1100..=0b10_1111 => miscellaneous(top),
        0b11_0000 | 0b11_0001 => Kind::Stm,
        0b11_0010 | 0b11_0011 => Kind::Ldm,
        0b11_0100..=0b11_0111 => conditional_branch(top),
        0b11_1000 | 0b11_1001 => Kind::B,
        0b11_1100 | 0b11_1101 => Kind::Wide,
        _ => Kind::Undefined,
    }
}

/// A5.2.1.
const fn shift_add_move_compare(top: u16) -> Kind {
    match top >> 3 & 0b11111 {
        0b00000..=0b00011 => Kind::LslImmediate,
        0b00100..=0b00111 => Kind::LsrImmediate,
        0b01000..=0b01011 => Kind::AsrImmediate,
        0b01100 => Kind::AddRegister,
        0b01101 => Kind::SubRegister,
        0b01110 => Kind::AddImmediate3,
        0b01111 => Kind::SubImmediate3,
        0b10000..=0b10011 => Kind::MovImmediate,
        0b10100..=0b10111 => Kind::CmpImmediate,
        0b11000..=0b11011 => Kind::AddImmediate8,
        _ => Kind::SubImmediate8,
    }
}

/// A5.2.2: bits 9 to 6.
const fn data_processing(top: u16) -> Kind {
    match top & 0b1111 {
        0b0000 => Kind::And,
        0b0001 => Kind::Eor,
        0b0010 => Kind::Lsl,
        0b0011 => Kind::Lsr,
        0b0100 => Kind::Asr,
        0b0101 => Kind::Adc,
        0b0110 => Kind::Sbc,
        0b0111 => Kind::Ror,
        0b1000 => Kind::Tst,
        0b1001 => Kind::Rsb,
        0b1010 => Kind::Cmp,
        0b1011 => Kind::Cmn,
        0b1100 => Kind::Orr,
        0b1101 => Kind::Mul,
        0b1110 => Kind::Bic,
        _ => Kind::Mvn,
    }
}

/// A5.2.3: bits 9 to 6.
const fn special_data_and_branch(top: u16) -> Kind {
    match top & 0b1111 {
        0b0000..=0b0011 => Kind::AddAnyRegister,
        0b0100..=0b0111 => Kind::CmpAnyRegister,
        0b1000..=0b1011 => Kind::MovAnyRegister,
        0b1100 | 0b1101 => Kind::Bx,
        _ => Kind::Blx,
    }
}

/// A5.2.4: bits 15 to 9.
const fn load_store_single(top: u16) -> Kind {
    match top >> 3 {
        0b010_1000 => Kind::StrRegister,
        0b010_1001 => Kind::StrhRegister,
        0b010_1010 => Kind::StrbRegister,
        0b010_1011 => Kind::LdrsbRegister,
        0b010_1100 => Kind::LdrRegister,
        0b010_1101 => Kind::LdrhRegister,
        0b010_1110 => Kind::LdrbRegister,
        0b010_1111 => Kind::LdrshRegister,
        0b011_0000..=0b011_0011 => Kind::StrImmediate,
        0b011_0100..=0b011_0111 => Kind::LdrImmediate,
        0b011_1000..=0b011_1011 => Kind::StrbImmediate,
        0b011_1100..=0b011_1111 => Kind::LdrbImmediate,
        0b100_0000..=0b100_0011 => Kind::StrhImmediate,
        0b100_0100..=0b100_0111 => Kind::LdrhImmediate,
        0b100_1000..=0b100_1011 => Kind::StrSp,
        _ => Kind::LdrSp,
    }
}

/// A5.2.5: bits 11 to 6.
const fn miscellaneous(top: u16) -> Kind {
    match top & 0b11_1111 {
        0b00_0000 | 0b00_0001 => Kind::AddSpImmediate,
        0b00_0010 | 0b00_0011 => Kind::SubSpImmediate,
        0b00_1000 => Kind::Sxth,
        0b00_1001 => Kind::Sxtb,
        0b00_1010 => Kind::Uxth,
        0b00_1011 => Kind::Uxtb,
        0b01_0000..=0b01_0111 => Kind::Push,
        0b01_1001 => Kind::Cps,
        0b10_1000 => Kind::Rev,
        0b10_1001 => Kind::Rev16,
        0b10_1011 => Kind::Revsh,
        0b11_0000..=0b11_0111 => Kind::Pop,
        0b11_1000..=0b11_1011 => Kind::Bkpt,
        0b11_1100..=0b11_1111 => Kind::Hint,
        _ => Kind::Undefined,
    }
}

/// A5.2.6: the condition is in bits 11 to 8.
const fn conditional_branch(top: u16) -> Kind {
    match top >> 2 & 0b1111 {
        0b1110 => Kind::Undefined,
        0b1111 => Kind::Svc,
        _ => Kind::BConditional,
    }
}
