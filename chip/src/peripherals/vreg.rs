//! VREG_AND_CHIP_RESET (2.10, 2.12): storage, always in regulation, and the chip-level reset flags.

use super::{RegisterWrite, Written};

/// Register offsets.
const VREG: u32 = 0x0;
const BOD: u32 = 0x4;
const CHIP_RESET: u32 = 0x8;

const VREG_ROK: u32 = 1 << 12;
const VREG_WRITABLE: u32 = 0xf3;
const HAD_POR: u32 = 1 << 8;

/// The VREG_AND_CHIP_RESET block.
#[derive(Clone, Debug)]
pub(crate) struct Vreg {
    regulator: u32,
    brown_out: u32,
}

impl Default for Vreg {
    fn default() -> Self {
        Vreg { regulator: 0xb1, brown_out: 0x91 }
    }
}

impl Vreg {
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            VREG => Some(self.regulator | VREG_ROK),
            BOD => Some(self.brown_out),
            // The flag stays until the next chip-level reset; RUN and the rescue port are never
            // used here.
            CHIP_RESET => Some(HAD_POR),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        match offset {
            VREG => self.regulator = write.onto(self.regulator) & VREG_WRITABLE,
            BOD => self.brown_out = write.onto(self.brown_out) & 0xf1,
            CHIP_RESET => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_voltage_is_stored_and_in_regulation() {
        let mut vreg = Vreg::default();
        assert_eq!(vreg.read(VREG), Some(0x10b1));
        assert_eq!(vreg.write(VREG, RegisterWrite::plain(0xe1)), Written::Done);
        assert_eq!(vreg.read(VREG), Some(0x10e1));
        assert_eq!(vreg.read(CHIP_RESET), Some(HAD_POR));
    }
}
