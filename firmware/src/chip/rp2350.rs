//! The RP2350's Arm cores. All that differs from the RP2040 is here, and where its linker scripts
//! `rp2350.x` and `memory.x` put things.
//!
//! There are no first instructions of ours here as in `rp2040/start.rs`: the pins wait for
//! Embassy's initialisation, and their pull-ups vent the valves meanwhile.

use cortex_m::register::basepri;
use embassy_rp::interrupt;
use embassy_rp::interrupt::Priority;
use embassy_rp::pac::{self, Interrupt};
use pneudrive_protocol::pages::ChipKind;

/// What the board's pages say it is.
pub const KIND: ChipKind = ChipKind::Rp2350;
/// Embassy's default system clock, Hz.
pub const SYSTEM_CLOCK_HZ: u32 = 150_000_000;
/// The microsecond timer that Embassy's clock reads.
pub const TIMER: pac::timer::Timer = pac::TIMER0;
/// Alarm 0, Embassy's.
pub const EMBASSY_TIMER_IRQ: Interrupt = Interrupt::TIMER0_IRQ_0;
/// Alarm 1, ours.
pub const ANSWER_TIMER_IRQ: Interrupt = Interrupt::TIMER0_IRQ_1;

/// Lines of the interrupt controller.
pub const INTERRUPT_LINES: usize = 52;

/// Embassy's initialisation waits for the crystal.
pub fn wait_for_crystal() {}

/// Lets SIO drive a pin, whose pad the last reset has isolated (datasheet 9.7).
#[inline(always)]
pub fn drive_by_sio(pin: usize) {
    pac::PADS_BANK0.gpio(pin).modify(|w| w.set_iso(false));
    pac::IO_BANK0
        .gpio(pin)
        .ctrl()
        .write(|w| w.set_funcsel(pac::io::vals::Gpio0ctrlFuncsel::SIOB_PROC_0 as u8));
}

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
