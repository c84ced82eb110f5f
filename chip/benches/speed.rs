//! How fast the emulation is: `cargo bench -p pneudrive-chip`.

use divan::Bencher;
use divan::counter::ItemsCount;
use pneudrive_chip::{Chip, Ticks};

fn main() {
    divan::main();
}

/// Flash with a vector table at 0x100 and a program at 0x200.
fn flash(program: &[u16]) -> Vec<u8> {
    let mut flash = vec![0xff; 0x200];
    flash[0x100..0x104].copy_from_slice(&0x2004_0000_u32.to_le_bytes());
    flash[0x104..0x108].copy_from_slice(&0x1000_0201_u32.to_le_bytes());
    flash.extend(program.iter().flat_map(|opcode| opcode.to_le_bytes()));
    flash
}

/// A checksum over 64 words of RAM for ever: loads, arithmetic, shifts, a store, a call.
const CHECKSUM: &[u16] = &[
    0x2720, // movs r7, #0x20
    0x063f, // lsls r7, r7, #24   r7 = 0x2000_0000
    0x2400, // movs r4, #0        outer:
    0x2500, // movs r5, #0
    0x593e, // ldr  r6, [r7, r4]  inner:
    0x1976, // adds r6, r6, r5
    0x0873, // lsrs r3, r6, #1
    0x405d, // eors r5, r3
    0x43f6, // mvns r6, r6
    0x513e, // str  r6, [r7, r4]
    0xf000, // bl   leaf
    0xf804, //
    0x3404, // adds r4, #4
    0x2cff, // cmp  r4, #255
    0xd3f4, // bcc  inner
    0xe7f1, // b    outer
    0xb530, // push {r4, r5, lr}  leaf:
    0x1c6d, // adds r5, r5, #1
    0xbd30, // pop  {r4, r5, pc}
];

/// Polls UART0's flag register for ever: every other instruction reaches a peripheral.
const POLLING: &[u16] = &[
    0x4803, // ldr  r0, [pc, #12]
    0x4904, // ldr  r1, [pc, #16]
    0x6001, // str  r1, [r0, #0]     releases every peripheral from reset
    0x4804, // ldr  r0, [pc, #16]
    0x6981, // ldr  r1, [r0, #0x18]  loop:
    0xe7fd, // b    loop
    0xbf00, // nop
    0xbf00, // nop
    0xf000, // .word 0x4000_f000: RESETS RESET through the clear alias
    0x4000, //
    0xffff, // .word 0xffff_ffff
    0xffff, //
    0x4000, // .word 0x4003_4000: UART0
    0x4003, //
];

/// The same code, copied to RAM first: words from 0x1000_0300 on to 0x2000_1000.
const COPY_AND_JUMP: &[u16] = &[
    0x4804, // ldr  r0, [pc, #16]
    0x4905, // ldr  r1, [pc, #20]
    0x2440, // movs r4, #64
    0xc804, // ldm  r0!, {r2}     next:
    0xc104, // stm  r1!, {r2}
    0x3c04, // subs r4, #4
    0xd1fb, // bne  next
    0x4803, // ldr  r0, [pc, #12]
    0x4700, // bx   r0
    0xbf00, // nop
    0x0300, // .word 0x1000_0300
    0x1000, //
    0x1000, // .word 0x2000_1000
    0x2000, //
    0x1001, // .word 0x2000_1001
    0x2000, //
];

/// Runs 10 ms of virtual time at the ring oscillator's 6.5 MHz.
fn run(bencher: Bencher<'_, '_>, program: &[u16]) {
    run_flash(bencher, &flash(program));
}

fn run_flash(bencher: Bencher<'_, '_>, flash: &[u8]) {
    let mut chip = Chip::from_flash(flash).expect("a program");
    let mut end = Ticks::from_millis(10);
    chip.run_until(end);
    let instructions = chip.instructions();
    assert_healthy(&chip);
    bencher.counter(ItemsCount::new(instructions)).bench_local(|| {
        end += Ticks::from_millis(10);
        chip.run_until(end);
    });
    assert_healthy(&chip);
}

/// The program does what it was written for.
fn assert_healthy(chip: &Chip) {
    assert_eq!(chip.last_hard_fault(), None);
    assert_eq!(chip.unmodelled_accesses().count(), 0);
}

/// Items are instructions.
#[divan::bench]
fn checksum(bencher: Bencher<'_, '_>) {
    run(bencher, CHECKSUM);
}

/// Items are instructions.
#[divan::bench]
fn checksum_in_ram(bencher: Bencher<'_, '_>) {
    let mut flash = flash(COPY_AND_JUMP);
    flash.resize(0x300, 0xff);
    flash.extend(CHECKSUM.iter().flat_map(|opcode| opcode.to_le_bytes()));
    run_flash(bencher, &flash);
}

/// Items are instructions.
#[divan::bench]
fn polling_a_peripheral(bencher: Bencher<'_, '_>) {
    run(bencher, POLLING);
}
