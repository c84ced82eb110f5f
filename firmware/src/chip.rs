//! What differs between the RP2040 and the RP2350.

#[cfg(feature = "rp2040")]
pub use rp2040::*;
#[cfg(feature = "rp2350")]
pub use rp2350::*;

/// Number of the exception being handled (IPSR): 16 and more are interrupts. In assembly, because every critical section asks for it.
#[inline(always)]
fn active_exception() -> u32 {
    let number: u32;
    // SAFETY: reads a register of the processor.
    unsafe { core::arch::asm!("mrs {}, IPSR", out(reg) number, options(nomem, nostack, preserves_flags)) };
    number
}

#[cfg(feature = "rp2040")]
mod rp2040 {
    use cortex_m::peripheral::NVIC;
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

    const BUS_INTERRUPTS: u32 = 1 << Interrupt::DMA_IRQ_1 as u16 | 1 << ANSWER_TIMER_IRQ as u16;

    /// A DMA channel's count of transfers.
    pub fn set_transfer_count(channel: pac::dma::Channel, count: u32) {
        channel.trans_count().write_value(count);
    }

    /// Whether the processor handles one of the bus's interrupts.
    #[inline(always)]
    pub fn in_bus_interrupt() -> bool {
        // Both are among the first 16, so one shift by 0 to 47 finds them.
        const { assert!(BUS_INTERRUPTS < 1 << 16) };
        (BUS_INTERRUPTS << 16).checked_shr(super::active_exception()).is_some_and(|shifted| shifted & 1 == 1)
    }

    /// Disables every interrupt but the bus's two; gives those that it has disabled. ARMv6-M cannot mask by priority
    /// (it has no BASEPRI), so it is done one by one.
    pub fn mask_all_but_the_bus() -> u32 {
        // SAFETY: single registers of the NVIC; an interrupt between the two accesses leaves them as it found them.
        let nvic = unsafe { &*NVIC::PTR };
        let enabled = nvic.iser[0].read() & !BUS_INTERRUPTS;
        // SAFETY: ones disable, zeros do nothing.
        unsafe { nvic.icer[0].write(enabled) };
        // An interrupt that has been recognised already is taken before this has passed, not later.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        enabled
    }

    /// Enables interrupts again.
    ///
    /// # Safety
    /// Whatever relied on their being masked must have ended.
    pub unsafe fn unmask(enabled: u32) {
        // SAFETY: ones enable, zeros do nothing.
        unsafe { (*NVIC::PTR).iser[0].write(enabled) };
    }

    #[interrupt]
    fn TIMER_IRQ_1() {
        crate::bus::on_answer_alarm();
    }
}

#[cfg(feature = "rp2350")]
mod rp2350 {
    use cortex_m::register::basepri;
    use embassy_rp::interrupt;
    use embassy_rp::interrupt::Priority;
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

    /// Whether the processor handles one of the bus's interrupts.
    pub fn in_bus_interrupt() -> bool {
        let bus = [Interrupt::DMA_IRQ_1, ANSWER_TIMER_IRQ].map(|interrupt| 16 + interrupt as u32);
        bus.contains(&super::active_exception())
    }

    /// Masks every interrupt below the bus's priority, P0; gives the mask that was set before.
    pub fn mask_all_but_the_bus() -> u32 {
        let before = basepri::read();
        // SAFETY: masking more is always sound.
        unsafe { basepri::write(Priority::P1 as u8) };
        before.into()
    }

    /// Restores the mask.
    ///
    /// # Safety
    /// Whatever relied on the interrupts' being masked must have ended.
    pub unsafe fn unmask(before: u32) {
        // SAFETY: the caller's promise.
        unsafe { basepri::write(before as u8) };
    }

    #[interrupt]
    fn TIMER0_IRQ_1() {
        crate::bus::on_answer_alarm();
    }
}
