//! Random instructions on this core and on the one of the crate `rp2040-emu`, which shares no code
//! with it.
//!
//! Left out is what the architecture calls unpredictable, where two correct cores may differ.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rp2040_emu::{Bus as OtherBus, CortexM0Plus};

use super::super::{Core, LR, PC, SP};
use super::{CODE, DATA};
use crate::bus::Bus;

/// Bytes of RAM that loads and stores may reach, around [`DATA`].
const WINDOW: u32 = 2048;

/// Both cores with their memories.
struct Pair {
    rng: ChaCha8Rng,
    ours: Core,
    our_bus: Bus,
    theirs: CortexM0Plus,
    their_bus: OtherBus,
}

impl Pair {
    fn new(seed: u64) -> Pair {
        let mut pair = Pair {
            rng: ChaCha8Rng::seed_from_u64(seed),
            ours: Core::new(),
            our_bus: Bus::new(Vec::new().into()),
            theirs: CortexM0Plus::new(),
            their_bus: OtherBus::default(),
        };
        pair.our_bus.interrupts_seen();
        for address in (DATA - WINDOW..DATA + WINDOW).step_by(4) {
            let word = pair.rng.random();
            pair.our_bus.write32(address, word).expect("SRAM");
            pair.their_bus.write32(address, word);
        }
        pair
    }

    /// Values where carries, signs and shift amounts turn over, as often as any.
    fn value(&mut self) -> u32 {
        const CORNERS: [u32; 12] =
            [0, 1, 2, 31, 32, 33, 255, 256, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, 0xffff_ffff];
        match self.rng.random_range(0..4) {
            0 => CORNERS[self.rng.random_range(0..CORNERS.len())],
            1 => self.rng.random_range(0..64),
            _ => self.rng.random(),
        }
    }

    /// The same random state in both cores.
    fn randomise(&mut self) {
        let mut registers: [u32; 16] = std::array::from_fn(|_| self.value());
        registers[SP] = DATA + 4 * self.rng.random_range(0..64);
        registers[PC] = CODE;
        self.set_registers(registers);
    }

    fn set_registers(&mut self, registers: [u32; 16]) {
        let flags = self.rng.random_range(0..16u32) << 28;
        self.ours.r = registers;
        self.ours.set_apsr(flags);
        self.theirs.regs.r = registers;
        self.theirs.regs.xpsr = flags | 1 << 24;
    }

    fn execute(&mut self, opcode: u16) {
        self.our_bus.write16(CODE, opcode).expect("SRAM");
        self.ours.step(&mut self.our_bus);
        self.theirs.execute_one_with_bus(opcode, &mut self.their_bus);
    }

    fn execute_wide(&mut self, first: u16, second: u16) {
        self.our_bus.write16(CODE, first).expect("SRAM");
        self.our_bus.write16(CODE + 2, second).expect("SRAM");
        self.ours.step(&mut self.our_bus);
        self.theirs.execute_one_wide_with_bus(first, second, &mut self.their_bus);
    }

    fn compare(&self, before: &[u32; 16], opcode: u16) {
        let theirs = (self.theirs.flag_n(), self.theirs.flag_z(), self.theirs.flag_c(), self.theirs.flag_v());
        let context = || format!("opcode {opcode:#06x} on {before:08x?}");
        assert_eq!(self.ours.counters.hard_faults, 0, "{}", context());
        assert_eq!(self.ours.r, self.theirs.regs.r, "{}", context());
        let flags = self.ours.flags;
        assert_eq!((flags.n(), flags.z(), flags.c, flags.v()), theirs, "{}", context());
    }

    fn compare_memory(&mut self, opcode: u16) {
        for address in (DATA - WINDOW..DATA + WINDOW).step_by(4) {
            let ours = self.our_bus.read32(address).expect("SRAM");
            assert_eq!(ours, self.their_bus.read32(address), "at {address:#x} after {opcode:#06x}");
        }
    }
}

/// A random encoding that only computes: A5.2.1 to A5.2.3 without branches, and the extensions and
/// reversals.
fn computation(rng: &mut ChaCha8Rng) -> u16 {
    loop {
        let opcode: u16 = match rng.random_range(0..8) {
            // Shift, add, subtract, move, compare.
            0..3 => rng.random_range(0x0000..0x4000),
            // Data processing.
            3 | 4 => rng.random_range(0x4000..0x4400),
            // ADD, CMP, MOV on all registers.
            5 => rng.random_range(0x4400..0x4700),
            // ADR and ADD Rd, SP.
            6 => rng.random_range(0xa000..0xb000),
            // SP adjustment, extension, reversal.
            _ => [0xb000, 0xb200, 0xba00][rng.random_range(0..3)] | rng.random_range(0..0x100),
        };
        let high_destination = opcode & 7 | opcode >> 4 & 8;
        let high_source = opcode >> 3 & 15;
        let touches_pc_or_sp = high_destination >= 13 || high_source >= 13;
        // High-register forms with two low registers or with the PC are branches or unpredictable.
        let compare_of_lows = opcode & 0xff00 == 0x4500 && high_destination < 8 && high_source < 8;
        let in_high_class = (0x4400..0x4700).contains(&opcode);
        let undefined_reversal = opcode & 0xffc0 == 0xba80;
        if !(in_high_class && (touches_pc_or_sp || compare_of_lows)) && !undefined_reversal {
            return opcode;
        }
    }
}

#[test]
fn computations_agree() {
    let mut pair = Pair::new(1);
    for _ in 0..300_000 {
        pair.randomise();
        let before = pair.ours.r;
        let opcode = computation(&mut pair.rng);
        pair.execute(opcode);
        pair.compare(&before, opcode);
    }
}

#[test]
fn moves_and_additions_to_the_stack_pointer_agree() {
    let mut pair = Pair::new(2);
    for _ in 0..20_000 {
        pair.randomise();
        let mut registers = pair.ours.r;
        let source = pair.rng.random_range(0..13u16);
        registers[usize::from(source)] = 4 * pair.rng.random_range(0..64u32);
        pair.set_registers(registers);
        // ADD SP, Rm; MOV SP, Rm; ADD Rd, SP; MOV Rd, SP; MOV Rd, PC.
        let opcode = match pair.rng.random_range(0..5) {
            0 => 0x4485 | source << 3,
            1 => 0x4685 | source << 3,
            2 => 0x4468 | source & 7,
            3 => 0x4668 | source & 7,
            _ => 0x4678 | source & 7,
        };
        pair.execute(opcode);
        pair.compare(&registers, opcode);
    }
}

#[test]
fn single_loads_and_stores_agree() {
    let mut pair = Pair::new(3);
    for i in 0..100_000 {
        pair.randomise();
        // 0x5000 to 0x9fff: all register, immediate and stack forms.
        let opcode: u16 = pair.rng.random_range(0x5000..0xa000);
        let base = usize::from(opcode >> 3 & 7);
        let index = usize::from(opcode >> 6 & 7);
        let mut registers = pair.ours.r;
        registers[base] = DATA + 4 * pair.rng.random_range(0..64u32);
        if opcode < 0x6000 {
            if base == index {
                continue;
            }
            registers[index] = 4 * pair.rng.random_range(0..64u32);
        }
        pair.set_registers(registers);
        pair.execute(opcode);
        pair.compare(&registers, opcode);
        if i % 256 == 0 {
            pair.compare_memory(opcode);
        }
    }
    pair.compare_memory(0);
}

#[test]
fn narrow_accesses_at_every_offset_agree() {
    let mut pair = Pair::new(4);
    for _ in 0..50_000 {
        pair.randomise();
        let (halfword, opcode): (bool, u16) = match pair.rng.random_range(0..6) {
            // STRB, LDRB, STRH, LDRH immediate.
            0 => (false, pair.rng.random_range(0x7000..0x8000)),
            1 => (true, pair.rng.random_range(0x8000..0x9000)),
            // STRH, STRB, LDRSB, LDRH, LDRB, LDRSH register: base r1, index r2.
            2 => (true, 0x5288 | pair.rng.random_range(0..8)),
            3 => (false, 0x5688 | pair.rng.random_range(0..8)),
            4 => (true, 0x5e88 | pair.rng.random_range(0..8)),
            _ => (false, 0x5488 | pair.rng.random_range(0..8)),
        };
        let mut registers = pair.ours.r;
        let unit = if halfword { 2 } else { 1 };
        registers[2] = unit * pair.rng.random_range(0..128u32);
        registers[usize::from(opcode >> 3 & 7)] = DATA + unit * pair.rng.random_range(0..128u32);
        pair.set_registers(registers);
        pair.execute(opcode);
        pair.compare(&registers, opcode);
    }
    pair.compare_memory(0);
}

#[test]
fn multiple_loads_and_stores_agree() {
    let mut pair = Pair::new(5);
    for i in 0..50_000 {
        pair.randomise();
        let mut registers = pair.ours.r;
        let list: u16 = pair.rng.random_range(1..256);
        let base = pair.rng.random_range(0..8u16);
        registers[usize::from(base)] = DATA + 4 * pair.rng.random_range(0..64u32);
        let opcode = match pair.rng.random_range(0..4) {
            // STM stores an unknown value for a base that is not the lowest register of the list.
            0 if list >> base & 1 != 0 && list.trailing_zeros() != u32::from(base) => continue,
            0 => 0xc000 | base << 8 | list,
            1 => 0xc800 | base << 8 | list,
            2 => 0xb400 | list | pair.rng.random_range(0..2) << 8,
            _ => 0xbc00 | list,
        };
        pair.set_registers(registers);
        pair.execute(opcode);
        pair.compare(&registers, opcode);
        if i % 256 == 0 {
            pair.compare_memory(opcode);
        }
    }
    pair.compare_memory(0);
}

#[test]
fn branches_agree() {
    let mut pair = Pair::new(6);
    for _ in 0..50_000 {
        pair.randomise();
        let mut registers = pair.ours.r;
        let target = CODE + 2 * pair.rng.random_range(0..0x400u32);
        let register = pair.rng.random_range(0..13u16);
        registers[usize::from(register)] = target | 1;
        registers[LR] = target | 1;
        let opcode = match pair.rng.random_range(0..6) {
            // All conditions; 14 is undefined, 15 SVC.
            0..2 => 0xd000 | pair.rng.random_range(0..14) << 8 | pair.rng.random_range(0..256),
            2 => 0xe000 | pair.rng.random_range(0..0x800),
            // BX, BLX, MOV PC.
            3 => 0x4700 | register << 3,
            4 => 0x4780 | register << 3,
            _ => 0x4687 | register << 3,
        };
        pair.set_registers(registers);
        pair.execute(opcode);
        pair.compare(&registers, opcode);
    }
}

#[test]
fn calls_agree() {
    let mut pair = Pair::new(7);
    for _ in 0..50_000 {
        pair.randomise();
        let before = pair.ours.r;
        let first = 0xf000 | pair.rng.random_range(0..0x800);
        let second = 0xd000
            | pair.rng.random_range(0..0x800)
            | pair.rng.random_range(0..2) << 13
            | pair.rng.random_range(0..2) << 11;
        pair.execute_wide(first, second);
        pair.compare(&before, first);
    }
}
