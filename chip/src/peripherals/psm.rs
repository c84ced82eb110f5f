//! PSM, the power-on state machine (2.13): which stages a watchdog reset restarts.

use super::{RegisterWrite, Written};

/// Register offsets.
const FRCE_ON: u32 = 0x0;
const FRCE_OFF: u32 = 0x4;
const WDSEL: u32 = 0x8;
const DONE: u32 = 0xc;

/// All 17 stages.
const ALL: u32 = 0x0001_ffff;
/// Stage numbers.
const CLOCKS: u32 = 2;
const RESETS: u32 = 3;
const SIO: u32 = 14;
const PROC0: u32 = 15;
const PROC1: u32 = 16;

/// The PSM block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Psm {
    force_on: u32,
    force_off: u32,
    watchdog_select: u32,
}

impl Psm {
    pub fn read(&self, offset: u32) -> Option<u32> {
        match offset {
            FRCE_ON => Some(self.force_on),
            FRCE_OFF => Some(self.force_off),
            WDSEL => Some(self.watchdog_select),
            DONE => Some(ALL & !self.force_off),
            _ => None,
        }
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        match offset {
            FRCE_ON => self.force_on = write.onto(self.force_on) & ALL,
            FRCE_OFF => {
                self.force_off = write.onto(self.force_off) & ALL;
                // SIO is reset by the bus; core 1 never runs here. Anything else would matter.
                if self.force_off & !(1 << PROC1 | 1 << SIO) != 0 {
                    return Written::ValueNotModelled;
                }
            }
            WDSEL => self.watchdog_select = write.onto(self.watchdog_select) & ALL,
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// SIO is being held in reset, as embassy-rp does at start to free the spinlocks.
    pub fn holds_sio(&self) -> bool {
        self.force_off >> SIO & 1 != 0
    }

    /// The watchdog restarts processor 0.
    pub fn watchdog_resets_processor(&self) -> bool {
        self.watchdog_select >> PROC0 & 1 != 0
    }

    /// The watchdog puts every peripheral back into reset.
    pub fn watchdog_resets_peripherals(&self) -> bool {
        self.watchdog_select >> RESETS & 1 != 0
    }

    /// The watchdog resets the clock generators.
    pub fn watchdog_resets_clocks(&self) -> bool {
        self.watchdog_select >> CLOCKS & 1 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_wdsel_the_watchdog_resets_nothing() {
        let mut psm = Psm::default();
        assert!(!psm.watchdog_resets_processor());
        assert_eq!(psm.write(WDSEL, RegisterWrite::plain(0x1_fffc)), Written::Done);
        assert!(psm.watchdog_resets_processor() && psm.watchdog_resets_peripherals());
        assert!(psm.watchdog_resets_clocks());
    }

    #[test]
    fn every_stage_is_done_except_a_forced_off_core_1() {
        let mut psm = Psm::default();
        assert_eq!(psm.read(DONE), Some(ALL));
        assert_eq!(psm.write(FRCE_OFF, RegisterWrite::plain(1 << PROC1)), Written::Done);
        assert_eq!(psm.read(DONE), Some(ALL & !(1 << PROC1)));
        assert_eq!(psm.write(FRCE_OFF, RegisterWrite::plain(1 << 5)), Written::ValueNotModelled);
    }
}
