//! What goes wrong inside the package: for tests of what a program does about it.

use crate::chip::Chip;
use crate::ticks::Ticks;

impl Chip {
    /// The processor executes nothing until `until`, as while it waits for flash; peripherals, DMA
    /// and watchdog go on. A reset ends it.
    pub fn stall_until(&mut self, until: Ticks) {
        self.stalled_until = until;
    }

    /// A DMA channel loses what it was doing and is no longer busy, as by CHAN_ABORT (datasheet
    /// 2.5.5.3): it neither raises its interrupt nor triggers the channel that it is chained to.
    ///
    /// # Panics
    ///
    /// If there is no such channel.
    pub fn abort_dma(&mut self, channel: usize) {
        self.bus.abort_dma(channel);
    }

    /// Whether the ADC's conversions fail from now on: they end in time, with a result and with
    /// CS.ERR and CS.ERR_STICKY set (datasheet 4.9.2.1).
    pub fn set_adc_failing(&mut self, failing: bool) {
        self.bus.adc.set_failing(failing);
    }
}
