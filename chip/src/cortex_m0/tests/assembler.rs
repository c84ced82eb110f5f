//! The few instructions the test programs need (ARMv6-M A6.7).

pub const NOP: u16 = 0xbf00;
pub const WFE: u16 = 0xbf20;
pub const WFI: u16 = 0xbf30;
pub const SEV: u16 = 0xbf40;
pub const BX_LR: u16 = 0x4770;
pub const SVC: u16 = 0xdf00;
pub const UDF: u16 = 0xde00;
pub const BKPT: u16 = 0xbe00;
/// `B .`
pub const HANG: u16 = 0xe7fe;
pub const CPSID: u16 = 0xb672;
pub const CPSIE: u16 = 0xb662;

/// `MOVS Rd, #imm`
pub fn movs(rd: u16, imm: u16) -> u16 {
    0x2000 | rd << 8 | imm
}

/// `ADDS Rd, #imm`
pub fn adds(rd: u16, imm: u16) -> u16 {
    0x3000 | rd << 8 | imm
}

/// `LDR Rt, [Rn, #4 * offset]`
pub fn ldr(rt: u16, rn: u16, offset: u16) -> u16 {
    0x6800 | offset << 6 | rn << 3 | rt
}

/// `STR Rt, [Rn, #4 * offset]`
pub fn str(rt: u16, rn: u16, offset: u16) -> u16 {
    0x6000 | offset << 6 | rn << 3 | rt
}

/// `PUSH {list}`; bit 8 is LR.
pub fn push(list: u16) -> u16 {
    0xb400 | list
}

/// `POP {list}`; bit 8 is PC.
pub fn pop(list: u16) -> u16 {
    0xbc00 | list
}

/// `MSR special, Rn`
pub fn msr(special: u16, rn: u16) -> [u16; 2] {
    [0xf380 | rn, 0x8800 | special]
}

/// `MRS Rd, special`
pub fn mrs(rd: u16, special: u16) -> [u16; 2] {
    [0xf3ef, 0x8000 | rd << 8 | special]
}
