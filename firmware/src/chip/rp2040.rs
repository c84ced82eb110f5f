//! The RP2040.

mod boot;
mod fault;
pub(crate) mod places;
mod program;
mod start;

pub use start::wait_for_crystal;

use cortex_m::peripheral::NVIC;
use embassy_rp::interrupt;
use embassy_rp::pac::{self, Interrupt};
use pneudrive_protocol::pages::ChipKind;

/// What the board's pages say it is.
pub const KIND: ChipKind = ChipKind::Rp2040;
/// Embassy's default system clock, Hz.
pub const SYSTEM_CLOCK_HZ: u32 = 125_000_000;
/// The microsecond timer that Embassy's clock reads.
pub const TIMER: pac::timer::Timer = pac::TIMER;
/// Alarm 0, Embassy's.
pub const EMBASSY_TIMER_IRQ: Interrupt = Interrupt::TIMER_IRQ_0;
/// Alarm 1, ours.
pub const ANSWER_TIMER_IRQ: Interrupt = Interrupt::TIMER_IRQ_1;

const BUS_INTERRUPTS: u32 = 1 << Interrupt::DMA_IRQ_1 as u16 | 1 << ANSWER_TIMER_IRQ as u16;

/// Lets SIO drive a pin.
#[inline(always)]
pub fn drive_by_sio(pin: usize) {
    pac::IO_BANK0.gpio(pin).ctrl().write(|w| w.set_funcsel(pac::io::vals::Gpio0ctrlFuncsel::SIO_0 as u8));
}

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

/// Disables every interrupt but the bus's two; gives those that it has disabled. ARMv6-M cannot
/// mask by priority (it has no BASEPRI), so it is done one by one.
pub fn mask_all_but_the_bus() -> u32 {
    // SAFETY: single registers of the NVIC; an interrupt between the two accesses leaves them as it
    // found them.
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
