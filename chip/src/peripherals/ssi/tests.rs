use super::*;

fn write(ssi: &mut Ssi, offset: u32, value: u32, now: Ticks) {
    let clk_sys = Rate::hertz(125_000_000, 1);
    assert_eq!(ssi.write(offset, RegisterWrite::plain(value), clk_sys, now), Written::Done, "{offset:#x}");
}

/// With the W25Q080's boot loader: address and mode bits 8 clocks, wait 4, data 8, each two cycles.
#[test]
fn a_quad_read_without_instruction_takes_20_serial_clocks() {
    let mut ssi = Ssi::after_boot_loader();
    assert_eq!(ssi.read_cycles(), 20 * 2 + READ_OVERHEAD);
    assert!(ssi.can_read());
    ssi.divider = 4;
    assert_eq!(ssi.read_cycles(), 20 * 4 + READ_OVERHEAD);
}

/// Any flash chip: instruction 03h, 24 bits of address and 32 of data on one line.
#[test]
fn a_serial_read_takes_64_serial_clocks() {
    let mut ssi = Ssi::after_boot_rom();
    let start = Ticks::ZERO;
    write(&mut ssi, CTRLR0, 31 << 16 | 3 << 8, start);
    write(&mut ssi, SPI_CTRLR0, 0x0300_0000 | 6 << 2 | 2 << 8, start);
    write(&mut ssi, BAUDR, 4, start);
    assert!(!ssi.can_read(), "switched off");
    write(&mut ssi, SSIENR, 1, start);
    assert!(ssi.can_read());
    assert_eq!(ssi.read_cycles(), 64 * 4 + READ_OVERHEAD);
}

/// What the W25Q080's boot loader does, step by step.
#[test]
fn a_boot_loader_reads_the_status_and_starts_continuous_reads() {
    let mut ssi = Ssi::after_boot_rom();
    let start = Ticks::ZERO;
    write(&mut ssi, BAUDR, 2, start);
    write(&mut ssi, CTRLR0, 7 << 16, start);
    write(&mut ssi, SSIENR, 1, start);
    write(&mut ssi, DR0, 0x35, start);
    write(&mut ssi, DR0, 0x35, Ticks::new(2));
    let sent = Ticks::new(2 * 8 * 2);
    assert_eq!(ssi.read(SR, sent - Ticks::new(1)), Some(BUSY | TRANSMIT_NOT_FULL | RECEIVE_NOT_EMPTY));
    assert_eq!(ssi.read(SR, sent), Some(TRANSMIT_EMPTY | TRANSMIT_NOT_FULL | RECEIVE_NOT_EMPTY));
    assert_eq!((ssi.read(DR0, sent), ssi.read(DR0, sent)), (Some(0xff), Some(2)), "quad reads are enabled");

    write(&mut ssi, SSIENR, 0, sent);
    write(&mut ssi, CTRLR0, 0x005f_0300, sent);
    write(&mut ssi, SPI_CTRLR0, 0x2221, sent);
    write(&mut ssi, SSIENR, 1, sent);
    write(&mut ssi, DR0, 0xeb, sent);
    write(&mut ssi, DR0, 0xa0, sent);
    write(&mut ssi, SSIENR, 0, sent);
    write(&mut ssi, SPI_CTRLR0, 0xa000_2022, sent);
    write(&mut ssi, SSIENR, 1, sent);
    assert!(ssi.can_read());
    assert_eq!(ssi.read(SR, sent).map(|status| status & RECEIVE_NOT_EMPTY), Some(0), "switching off clears");
}

#[test]
fn instructions_nobody_knows_are_reported() {
    let mut ssi = Ssi::after_boot_rom();
    let start = Ticks::ZERO;
    write(&mut ssi, CTRLR0, 7 << 16, start);
    write(&mut ssi, SSIENR, 1, start);
    write(&mut ssi, DR0, 0x06, start);
    let clk_sys = Rate::hertz(125_000_000, 1);
    let second = ssi.write(DR0, RegisterWrite::plain(0), clk_sys, start);
    assert_eq!(second, Written::ValueNotModelled);
    assert_eq!(ssi.write(0x2c, RegisterWrite::plain(0), clk_sys, start), Written::NotModelled, "IMR");
}
