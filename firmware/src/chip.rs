//! What differs between the RP2040 and the RP2350.

#[cfg(feature = "rp2040")]
pub use rp2040::*;
#[cfg(feature = "rp2350")]
pub use rp2350::*;

#[cfg(feature = "rp2040")]
mod rp2040 {
    use embassy_rp::interrupt;
    use embassy_rp::pac::{self, Interrupt};

    /// Embassy's default system clock, Hz.
    pub const SYSTEM_CLOCK_HZ: u32 = 125_000_000;
    /// The microsecond timer that Embassy's clock reads.
    pub const TIMER: pac::timer::Timer = pac::TIMER;
    /// Alarm 0, Embassy's.
    pub const EMBASSY_TIMER_IRQ: Interrupt = Interrupt::TIMER_IRQ_0;
    /// Alarm 1, ours.
    pub const ANSWER_TIMER_IRQ: Interrupt = Interrupt::TIMER_IRQ_1;

    /// A DMA channel's count of transfers.
    pub fn set_transfer_count(channel: pac::dma::Channel, count: u32) {
        channel.trans_count().write_value(count);
    }

    #[interrupt]
    fn TIMER_IRQ_1() {
        crate::bus::on_answer_alarm();
    }
}

#[cfg(feature = "rp2350")]
mod rp2350 {
    use embassy_rp::interrupt;
    use embassy_rp::pac::{self, Interrupt};

    /// Embassy's default system clock, Hz.
    pub const SYSTEM_CLOCK_HZ: u32 = 150_000_000;
    /// The microsecond timer that Embassy's clock reads.
    pub const TIMER: pac::timer::Timer = pac::TIMER0;
    /// Alarm 0, Embassy's.
    pub const EMBASSY_TIMER_IRQ: Interrupt = Interrupt::TIMER0_IRQ_0;
    /// Alarm 1, ours.
    pub const ANSWER_TIMER_IRQ: Interrupt = Interrupt::TIMER0_IRQ_1;

    /// A DMA channel's count of transfers.
    pub fn set_transfer_count(channel: pac::dma::Channel, count: u32) {
        channel.trans_count().write(|w| w.set_count(count));
    }

    #[interrupt]
    fn TIMER0_IRQ_1() {
        crate::bus::on_answer_alarm();
    }
}
