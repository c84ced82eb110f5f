//! The program on a board: see the library's front page.
#![no_std]
#![no_main]

use core::panic::PanicInfo;
use cortex_m_rt::{ExceptionFrame, exception};
use embassy_executor::Spawner;
use pneudrive_firmware::safe_state;
use pneudrive_protocol::pages::{FaultRegisters, StopCause};

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    pneudrive_firmware::run(spawner).await;
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    safe_state::enter();
    // Where, but not what: formatting the message would cost more memory than the rest of the
    // firmware.
    let (file, line) = info.location().map_or(("", 0), |place| (place.file(), place.line()));
    safe_state::stop(StopCause::panic(file, line))
}

#[exception]
// SAFETY: called by the hardware only. It vents before it touches anything in RAM.
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    safe_state::enter();
    safe_state::stop(StopCause::HardFault(FaultRegisters {
        r: [frame.r0(), frame.r1(), frame.r2(), frame.r3()],
        r12: frame.r12(),
        lr: frame.lr(),
        pc: frame.pc(),
        xpsr: frame.xpsr(),
    }))
}
