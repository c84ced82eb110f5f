//! Both pins of every valve high: full vent. At boot, and when the program cannot go on.

use crate::pins::VALVE_PINS;
use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::pac;

/// Drives all valve pins high, whatever they did before. Registers only: it works at boot and in a panic.
pub fn enter() {
    pac::SIO.gpio_out(0).value_set().write_value(VALVE_PINS);
    pac::SIO.gpio_oe(0).value_set().write_value(VALVE_PINS);
    for pin in (0..32).filter(|pin| VALVE_PINS >> pin & 1 == 1) {
        #[cfg(feature = "rp2350")]
        pac::PADS_BANK0.gpio(pin).modify(|w| w.set_iso(false));
        #[cfg(feature = "rp2040")]
        pac::IO_BANK0.gpio(pin).ctrl().write(|w| w.set_funcsel(pac::io::vals::Gpio0ctrlFuncsel::SIO_0 as u8));
        #[cfg(feature = "rp2350")]
        pac::IO_BANK0
            .gpio(pin)
            .ctrl()
            .write(|w| w.set_funcsel(pac::io::vals::Gpio0ctrlFuncsel::SIOB_PROC_0 as u8));
    }
}

/// Vents, and waits for the watchdog to reset the chip.
fn vent_until_reset() -> ! {
    cortex_m::interrupt::disable();
    enter();
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    enter();
    // Where, but not what: formatting the message would cost more flash than the rest of the firmware.
    if let Some(place) = info.location() {
        defmt::error!("panic at {=str}:{=u32}", place.file(), place.line());
    }
    vent_until_reset()
}

#[exception]
// SAFETY: called by the hardware only. It touches nothing but registers.
unsafe fn HardFault(_frame: &ExceptionFrame) -> ! {
    vent_until_reset()
}
