use super::*;
use crate::parts::I2cPart;

/// Remembers what it is told, and sends 0x10, 0x11, ..
#[derive(Clone, Debug, Default)]
struct Probe {
    heard: Vec<String>,
    next: u8,
    refuses_after: Option<usize>,
}

impl I2cPart for Probe {
    fn start(&mut self, _now: Ticks, read: bool) -> bool {
        self.heard.push(if read { "R" } else { "W" }.into());
        true
    }

    fn write(&mut self, _now: Ticks, byte: u8) -> bool {
        self.heard.push(format!("{byte:02x}"));
        self.refuses_after.is_none_or(|bytes| self.heard.len() <= bytes)
    }

    fn read(&mut self, _now: Ticks) -> u8 {
        self.next += 1;
        self.heard.push("r".into());
        0x0f + self.next
    }

    fn stop(&mut self, _now: Ticks) {
        self.heard.push("P".into());
    }
}

/// At 125 MHz with the counts of 400 kHz: 313 cycles a bit.
const BIT: u64 = 125 + 11 + 7 + 187 + 1;

fn block(part: Probe) -> I2c {
    let mut i2c = I2c::default();
    i2c.set_clock((125_000_000, 1));
    i2c.wires.wire(4, 5);
    i2c.wires.connect(true);
    i2c.wires.attach(0x48, Box::new(part));
    for (offset, value) in
        [(IC_FS_SCL_HCNT, 125), (IC_FS_SCL_LCNT, 187), (IC_FS_SPKLEN, 11), (IC_TAR, 0x48), (IC_ENABLE, 1)]
    {
        assert_eq!(write(&mut i2c, offset, value), Written::Done);
    }
    i2c.set_lines_free(true, Ticks::ZERO);
    i2c
}

fn write(i2c: &mut I2c, offset: u32, value: u32) -> Written {
    i2c.write(offset, RegisterWrite::plain(value), Ticks::ZERO)
}

/// Runs until nothing happens any more; gives the time of the last event.
fn run(i2c: &mut I2c) -> Ticks {
    let mut last = Ticks::ZERO;
    while i2c.next_event() != Ticks::NEVER {
        last = i2c.next_event();
        i2c.advance(last);
    }
    last
}

fn heard(i2c: &mut I2c) -> String {
    let part: &mut dyn std::any::Any = i2c.wires.part_mut(0x48).expect("attached");
    part.downcast_ref::<Probe>().expect("a probe").heard.join(" ")
}

fn register(i2c: &mut I2c, offset: u32) -> u32 {
    i2c.read(offset).expect("modelled")
}

#[test]
fn bytes_are_written_in_their_time() {
    let mut i2c = block(Probe::default());
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT), TX_EMPTY);
    let _ = write(&mut i2c, IC_DATA_CMD, 0x01);
    let _ = write(&mut i2c, IC_DATA_CMD, 0x22 | CMD_STOP);
    assert_eq!(register(&mut i2c, IC_STATUS) & 0x21, 0x21, "active");
    let end = run(&mut i2c);
    assert_eq!(heard(&mut i2c), "W 01 22 P");
    assert_eq!(end, Ticks::new(BIT * (1 + 9 + 9 + 9 + 1)), "START, address, two bytes, STOP");
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT), TX_EMPTY | ACTIVITY | STOP_DET | START_DET);
    assert_eq!(register(&mut i2c, IC_CLR_STOP_DET), 0);
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT), TX_EMPTY | ACTIVITY | START_DET);
    assert_eq!(register(&mut i2c, IC_STATUS), 0x06);
}

#[test]
fn a_register_is_read_after_a_repeated_start() {
    let mut i2c = block(Probe::default());
    let _ = write(&mut i2c, IC_DATA_CMD, 0x05);
    run(&mut i2c);
    assert_eq!(heard(&mut i2c), "W 05", "the clock is held until there is a command");
    let _ = write(&mut i2c, IC_RX_TL, 1);
    let _ = write(&mut i2c, IC_INTR_MASK, RX_FULL);
    let _ = write(&mut i2c, IC_DATA_CMD, CMD_READ | CMD_RESTART);
    run(&mut i2c);
    assert!(!i2c.interrupt(), "one of two bytes");
    let _ = write(&mut i2c, IC_DATA_CMD, CMD_READ | CMD_STOP);
    run(&mut i2c);
    assert!(i2c.interrupt());
    assert_eq!(heard(&mut i2c), "W 05 R r r P");
    let bytes = [0; 3].map(|_| register(&mut i2c, IC_DATA_CMD));
    assert_eq!(bytes, [0x10, 0x11, 0], "the third is not there");
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT) & (RX_UNDER | RESTART_DET), RX_UNDER | RESTART_DET);
}

#[test]
fn nobody_at_an_address_aborts_the_transfer() {
    let mut i2c = block(Probe::default());
    i2c.wires.detach(0x48);
    for byte in 0..3 {
        let _ = write(&mut i2c, IC_DATA_CMD, byte);
    }
    let end = run(&mut i2c);
    assert_eq!(end, Ticks::new(BIT * 11));
    assert_eq!(register(&mut i2c, IC_TX_ABRT_SOURCE), ABRT_7B_ADDR_NOACK | 3 << 23, "three were thrown away");
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT) & (TX_ABRT | STOP_DET), TX_ABRT | STOP_DET);
    let _ = write(&mut i2c, IC_DATA_CMD, 7);
    assert_eq!(register(&mut i2c, IC_TXFLR), 0, "until the abort is cleared nothing is taken");
    assert_eq!(register(&mut i2c, IC_CLR_TX_ABRT), 0);
    assert_eq!(register(&mut i2c, IC_TX_ABRT_SOURCE), 0);
    let _ = write(&mut i2c, IC_DATA_CMD, 7);
    assert_eq!(register(&mut i2c, IC_TXFLR), 1);
}

#[test]
fn a_part_that_refuses_a_byte_aborts_the_transfer() {
    let mut i2c = block(Probe { refuses_after: Some(2), ..Probe::default() });
    for byte in 1..5 {
        let _ = write(&mut i2c, IC_DATA_CMD, byte);
    }
    run(&mut i2c);
    assert_eq!(heard(&mut i2c), "W 01 02 P");
    assert_eq!(register(&mut i2c, IC_TX_ABRT_SOURCE), ABRT_TXDATA_NOACK | 2 << 23);
}

#[test]
fn a_transfer_waits_until_the_lines_are_free() {
    let mut i2c = block(Probe::default());
    i2c.set_lines_free(false, Ticks::ZERO);
    let _ = write(&mut i2c, IC_DATA_CMD, 0x01 | CMD_STOP);
    assert_eq!((run(&mut i2c), heard(&mut i2c)), (Ticks::ZERO, String::new()));
    i2c.set_lines_free(true, Ticks::from_millis(3));
    assert_eq!(run(&mut i2c), Ticks::from_millis(3) + Ticks::new(20 * BIT));
    assert_eq!(heard(&mut i2c), "W 01 P");
}

#[test]
fn who_holds_sda_in_a_transfer_wins_it() {
    let mut i2c = block(Probe::default());
    let _ = write(&mut i2c, IC_DATA_CMD, 0x01 | CMD_STOP);
    i2c.advance(Ticks::new(12 * BIT));
    i2c.wires.hold_sda(9);
    run(&mut i2c);
    assert_eq!(register(&mut i2c, IC_TX_ABRT_SOURCE), ARB_LOST);
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT) & (TX_ABRT | STOP_DET), TX_ABRT, "no STOP");
    assert_eq!(heard(&mut i2c), "W");
}

#[test]
fn a_reset_in_the_middle_of_a_zero_leaves_sda_low() {
    // The part sends 0x10: bits 0001 0000.
    for (bits_sent, clocks) in [(0, 3), (2, 1), (3, 0), (4, 4), (7, 1), (8, 0)] {
        let mut i2c = block(Probe::default());
        let _ = write(&mut i2c, IC_DATA_CMD, CMD_READ | CMD_STOP);
        let at = Ticks::new(BIT * (10 + bits_sent) + 5);
        i2c.advance(at);
        i2c.reset(at);
        assert_eq!(i2c.wires.holds_sda(), clocks > 0, "after {bits_sent} bits");
        for clock in 0..clocks {
            assert!(i2c.wires.holds_sda(), "{clock} of {clocks} clocks after {bits_sent} bits");
            assert!(!i2c.wires.clock(false));
            assert_eq!(i2c.wires.clock(true), clock == clocks - 1);
        }
        assert!(!i2c.wires.holds_sda());
        assert_eq!(register(&mut i2c, IC_FS_SPKLEN), 7, "registers are as after power-on");
    }
}

#[test]
fn a_program_can_stop_a_transfer() {
    let mut i2c = block(Probe::default());
    let _ = write(&mut i2c, IC_DATA_CMD, 0x05);
    run(&mut i2c);
    let _ = write(&mut i2c, IC_ENABLE, 3);
    run(&mut i2c);
    assert_eq!(heard(&mut i2c), "W 05 P");
    assert_eq!(register(&mut i2c, IC_TX_ABRT_SOURCE), ABRT_USER_ABRT);
    assert_eq!(register(&mut i2c, IC_ENABLE), 1, "ABORT clears itself");
    // Switching it off in the middle of a byte ends after the byte.
    let _ = register(&mut i2c, IC_CLR_TX_ABRT);
    let _ = write(&mut i2c, IC_DATA_CMD, 0x06);
    let _ = write(&mut i2c, IC_DATA_CMD, 0x07);
    i2c.advance(Ticks::new(12 * BIT));
    let _ = write(&mut i2c, IC_ENABLE, 0);
    assert_eq!(register(&mut i2c, IC_ENABLE_STATUS), 1);
    run(&mut i2c);
    assert_eq!(heard(&mut i2c), "W 05 P W 06 P");
    assert_eq!(register(&mut i2c, IC_ENABLE_STATUS), 0);
}

#[test]
fn more_than_the_fifos_hold_is_lost_and_said() {
    let mut i2c = block(Probe::default());
    i2c.set_lines_free(false, Ticks::ZERO);
    for _ in 0..=FIFO_DEPTH {
        let _ = write(&mut i2c, IC_DATA_CMD, CMD_READ);
    }
    assert_eq!(register(&mut i2c, IC_RAW_INTR_STAT), TX_OVER);
    i2c.set_lines_free(true, Ticks::ZERO);
    run(&mut i2c);
    let _ = write(&mut i2c, IC_DATA_CMD, CMD_READ | CMD_STOP);
    run(&mut i2c);
    assert_eq!(register(&mut i2c, IC_RXFLR), 16);
    assert_ne!(register(&mut i2c, IC_RAW_INTR_STAT) & RX_OVER, 0);
}

#[test]
fn what_is_not_modelled_is_said() {
    let mut i2c = I2c::default();
    assert_eq!(write(&mut i2c, IC_CON, 0x65), Written::Done);
    assert_eq!(write(&mut i2c, IC_CON, 0x24), Written::ValueNotModelled, "a target");
    assert_eq!(write(&mut i2c, IC_CON, 0x75), Written::ValueNotModelled, "10-bit addresses");
    assert_eq!(write(&mut i2c, IC_DMA_CR, 1), Written::ValueNotModelled);
    assert_eq!(write(&mut i2c, IC_TAR, 0x448), Written::ValueNotModelled, "general call");
    assert_eq!(write(&mut i2c, 0xfc0, 0), Written::NotModelled);
    assert_eq!(i2c.read(0xa4), None);
}
