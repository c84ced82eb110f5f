//! Parts that boards do not know.

use pneudrive_chip::Ticks;
use pneudrive_chip::parts::I2cPart;

/// Four registers of two bytes, most significant first, some bits of which cannot be written.
#[derive(Clone, Debug)]
pub struct Stranger {
    registers: [u16; 4],
    always_one: u16,
    dummy_bytes: usize,
    bytes: Vec<u8>,
    pointer: usize,
    sent: usize,
    /// Registers that were written.
    pub written: u32,
}

impl Stranger {
    /// A TMP102: its configuration has R1 and R0, which read as 1.
    pub fn thermometer() -> Self {
        Self::new([0x1900, 0x60a0, 0x4b00, 0x5000], 0x6000, 0)
    }

    /// An IMU with another identification.
    pub fn other_imu() -> Self {
        Self::new([0x2424; 4], 0, 2)
    }

    fn new(registers: [u16; 4], always_one: u16, dummy_bytes: usize) -> Self {
        Self { registers, always_one, dummy_bytes, bytes: Vec::new(), pointer: 0, sent: 0, written: 0 }
    }
}

impl I2cPart for Stranger {
    fn start(&mut self, _now: Ticks, _read: bool) -> bool {
        self.bytes.clear();
        self.sent = 0;
        true
    }

    fn write(&mut self, _now: Ticks, byte: u8) -> bool {
        self.bytes.push(byte);
        match self.bytes[..] {
            [pointer] => self.pointer = usize::from(pointer) % 4,
            [_, high, low] => {
                self.registers[self.pointer] = u16::from_be_bytes([high, low]) | self.always_one;
                self.written += 1;
            }
            _ => {}
        }
        true
    }

    fn read(&mut self, _now: Ticks) -> u8 {
        let at = self.sent;
        self.sent += 1;
        at.checked_sub(self.dummy_bytes).map_or(0, |at| self.registers[self.pointer].to_be_bytes()[at % 2])
    }
}
