//! The flash chip behind the SSI, as far as second-stage boot loaders talk to it: Winbond W25Q080
//! and its family.

/// Instructions (W25Q80 datasheet, 8.1).
const READ_STATUS_1: u8 = 0x05;
const READ_STATUS_2: u8 = 0x35;
const FAST_READ_QUAD_IO: u8 = 0xeb;

/// Status register 2: QE, all four data lines may be used. Set when the parts with it leave the
/// factory.
const QUAD_ENABLE: u8 = 1 << 1;
/// Upper half of the mode bits that keeps the chip in continuous reads: the next one begins with
/// its address.
const CONTINUOUS: u8 = 0xa;

/// What the flash chip remembers between two instructions.
#[derive(Clone, Debug, Default)]
pub(crate) struct SerialFlash {
    /// Instruction of the transfer going on.
    instruction: Option<u8>,
    continuous: bool,
}

/// An instruction that this one does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct UnknownInstruction;

impl SerialFlash {
    /// In continuous reads, as boot loaders leave it.
    pub fn reading_continuously() -> SerialFlash {
        SerialFlash { instruction: None, continuous: true }
    }

    /// Chip select falls.
    pub fn select(&mut self) {
        self.instruction = None;
    }

    /// A byte in on one line, and the one that comes out meanwhile.
    pub fn exchange(&mut self, byte: u8) -> Result<u8, UnknownInstruction> {
        match self.instruction {
            None => {
                self.instruction = Some(byte);
                Ok(0xff)
            }
            // Never busy, nothing protected.
            Some(READ_STATUS_1) => Ok(0),
            Some(READ_STATUS_2) => Ok(QUAD_ENABLE),
            Some(_) => Err(UnknownInstruction),
        }
    }

    /// A read on four lines with its mode bits; none of the data is looked at.
    pub fn read_quad(&mut self, instruction: u8, mode: u8) -> Result<(), UnknownInstruction> {
        if instruction != FAST_READ_QUAD_IO {
            return Err(UnknownInstruction);
        }
        self.continuous = mode >> 4 == CONTINUOUS;
        Ok(())
    }

    /// Whether the next read begins with its address.
    pub fn is_continuous(&self) -> bool {
        self.continuous
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_follows_its_instruction_until_the_chip_is_selected_again() {
        let mut flash = SerialFlash::default();
        flash.select();
        assert_eq!(flash.exchange(READ_STATUS_2), Ok(0xff));
        assert_eq!(flash.exchange(0), Ok(QUAD_ENABLE));
        flash.select();
        assert_eq!(flash.exchange(READ_STATUS_1), Ok(0xff));
        assert_eq!(flash.exchange(READ_STATUS_2), Ok(0), "not an instruction now");
        flash.select();
        assert_eq!(flash.exchange(0x06), Ok(0xff));
        assert_eq!(flash.exchange(0), Err(UnknownInstruction));
    }

    #[test]
    fn the_mode_bits_decide_about_the_next_read() {
        let mut flash = SerialFlash::default();
        assert!(!flash.is_continuous());
        assert_eq!(flash.read_quad(FAST_READ_QUAD_IO, 0xa0), Ok(()));
        assert!(flash.is_continuous());
        assert_eq!(flash.read_quad(FAST_READ_QUAD_IO, 0x00), Ok(()));
        assert!(!flash.is_continuous());
        assert_eq!(flash.read_quad(0x6b, 0xa0), Err(UnknownInstruction));
    }
}
