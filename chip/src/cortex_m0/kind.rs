//! What an instruction is: a table over the top ten bits of a 16-bit instruction (A5.2), filled in
//! when the crate is compiled.

/// What an instruction is. Numbered without gaps, so that the jump is one through a table.
#[derive(Clone, Copy)]
pub(super) enum Kind {
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
pub(super) static KINDS: [Kind; 1024] = table();

const fn table() -> [Kind; 1024] {
    let mut table = [Kind::Undefined; 1024];
    let mut top = 0;
    while top < 1024 {
        table[top as usize] = kind(top);
        top += 1;
    }
    table
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
