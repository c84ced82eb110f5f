//! PADS_BANK0 (2.19.4): pulls, input enable and output disable of each pin.

use super::{RegisterWrite, Written};

/// Register offsets.
const VOLTAGE_SELECT: u32 = 0x00;
const GPIO0: u32 = 0x04;
const GPIO29: u32 = 0x78;
const SWCLK: u32 = 0x7c;
const SWD: u32 = 0x80;

const PDE: u32 = 1 << 2;
const PUE: u32 = 1 << 3;
const IE: u32 = 1 << 6;
const OD: u32 = 1 << 7;

/// 4 mA, Schmitt trigger, pull-down, input enabled.
const RESET_VALUE: u32 = 0x56;

/// The PADS_BANK0 block.
#[derive(Clone, Debug)]
pub(crate) struct Pads {
    voltage_select: u32,
    /// GPIO0 to 29, SWCLK, SWD.
    pads: [u32; 32],
}

impl Default for Pads {
    fn default() -> Self {
        let mut pads = [RESET_VALUE; 32];
        // SWCLK and SWD: pull-up, output disabled on SWCLK.
        pads[30] = 0xda;
        pads[31] = 0x5a;
        Pads { voltage_select: 0, pads }
    }
}

impl Pads {
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            VOLTAGE_SELECT => Some(self.voltage_select),
            GPIO0..=SWD => Some(self.pads[((offset - GPIO0) / 4) as usize]),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        match offset {
            VOLTAGE_SELECT => self.voltage_select = write.onto(self.voltage_select) & 1,
            GPIO0..=GPIO29 | SWCLK | SWD => {
                let pad = &mut self.pads[((offset - GPIO0) / 4) as usize];
                *pad = write.onto(*pad) & 0xff;
            }
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    pub fn input_enabled(&self, pin: usize) -> bool {
        self.pads[pin] & IE != 0
    }

    pub fn output_disabled(&self, pin: usize) -> bool {
        self.pads[pin] & OD != 0
    }

    /// The level the pull holds an undriven pin at; none without a pull, or with both (bus keeper).
    pub fn pull(&self, pin: usize) -> Option<bool> {
        match self.pads[pin] & (PUE | PDE) {
            PUE => Some(true),
            PDE => Some(false),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_reset_every_pin_is_pulled_down() {
        let pads = Pads::default();
        assert!((0..30).all(|pin| pads.pull(pin) == Some(false) && pads.input_enabled(pin)));
    }

    #[test]
    fn pulls_follow_their_bits() {
        let mut pads = Pads::default();
        assert_eq!(pads.write(GPIO0 + 4 * 14, RegisterWrite::plain(IE | PUE)), Written::Done);
        assert_eq!(pads.pull(14), Some(true));
        assert_eq!(pads.write(GPIO0 + 4 * 14, RegisterWrite::plain(OD)), Written::Done);
        assert_eq!(pads.pull(14), None);
        assert!(pads.output_disabled(14) && !pads.input_enabled(14));
    }
}
