//! Both pins of every valve high: full vent. At boot, and when the program cannot go on.

use crate::config::VALVE_PINS;
use crate::{chip, post_mortem};
use embassy_rp::pac;
use pneudrive_protocol::pages::StopCause;

/// Drives all valve pins high, whatever they did before. Registers only: it works at boot and in a
/// panic.
///
/// On the RP2350 it stays in flash beside the HardFault handler, where a stray write cannot change
/// it. On the RP2040 the boot stage's handler vents from there first.
#[inline(never)]
#[unsafe(link_section = ".HardFault.safe_state")]
pub fn enter() {
    pac::SIO.gpio_out(0).value_set().write_value(VALVE_PINS);
    pac::SIO.gpio_oe(0).value_set().write_value(VALVE_PINS);
    for pin in (0..30).filter(|pin| VALVE_PINS >> pin & 1 == 1) {
        chip::drive_by_sio(pin);
    }
}

/// Vents, remembers why, and waits for the watchdog to reset the chip. The log says it after the
/// reset ([`post_mortem`]).
pub fn stop(cause: StopCause) -> ! {
    cortex_m::interrupt::disable();
    enter();
    post_mortem::keep(cause);
    loop {
        cortex_m::asm::nop();
    }
}
