//! The RS-485 bus: every byte heard goes to the board, and its answers go out.
//!
//! Reception is done by two chained DMA channels ([`receiver`]); their interrupt hands the bytes to
//! the board with the times at which they came. An answer waits for its time on an alarm
//! ([`transmitter`]).

mod receiver;
mod transmitter;

use crate::shared::Shared;
use crate::{chip, shared};
use core::cell::RefCell;
use cortex_m::interrupt::{CriticalSection, Mutex};
use embassy_rp::Peri;
use embassy_rp::gpio::Output;
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, PIN_0, PIN_1, UART0};
use embassy_rp::uart::{self, Blocking, Uart};
use pneudrive_control::{BoardConfig, Micros};
use pneudrive_protocol::Baud;
use receiver::Receiver;
use transmitter::Transmitter;

/// What the bus needs of the chip.
pub struct BusHardware {
    /// The UART.
    pub uart: Peri<'static, UART0>,
    /// Its transmit pin.
    pub transmit: Peri<'static, PIN_0>,
    /// Its receive pin.
    pub receive: Peri<'static, PIN_1>,
    /// High while an answer is on the wire.
    pub driver_enable: Output<'static>,
    /// Carries the characters heard.
    pub characters: Peri<'static, DMA_CH0>,
    /// Carries their times.
    pub stamps: Peri<'static, DMA_CH1>,
}

struct Bus {
    receiver: Receiver,
    transmitter: Transmitter,
    answer_delay: Micros,
    /// Dropping it would switch it off.
    uart: Uart<'static, Blocking>,
}

static BUS: Mutex<RefCell<Option<Bus>>> = Mutex::new(RefCell::new(None));

/// Listens from now on. The board must have been installed.
pub fn start(hardware: BusHardware, config: &BoardConfig) {
    let mut uart_config = uart::Config::default();
    uart_config.baudrate = config.baud.get();
    let bus = Bus {
        uart: Uart::new_blocking(hardware.uart, hardware.transmit, hardware.receive, uart_config),
        receiver: Receiver::start(hardware.characters, hardware.stamps),
        transmitter: Transmitter::new(hardware.driver_enable, config.baud),
        answer_delay: config.answer_delay,
    };
    cortex_m::interrupt::free(|masked| BUS.borrow(masked).replace(Some(bus)));

    interrupt::DMA_IRQ_1.set_priority(Priority::P0);
    chip::ANSWER_TIMER_IRQ.set_priority(Priority::P0);
    // SAFETY: from here on the handlers may run, and everything they use is in place.
    unsafe {
        interrupt::DMA_IRQ_1.enable();
        chip::ANSWER_TIMER_IRQ.enable();
    }
}

/// Lets the receive interrupt run once without a byte, so that it can report that it lives.
pub fn ask_for_a_sign_of_life() {
    interrupt::DMA_IRQ_1.pend();
}

#[interrupt]
fn DMA_IRQ_1() {
    receiver::acknowledge();
    let alone = alone();
    within(&alone, |bus| shared::within(&alone, |shared| pass_on(bus, shared)));
}

/// Hands everything heard to the board, and its answer to the transmitter.
fn pass_on(bus: &mut Bus, shared: &mut Shared) {
    let now = shared::now();
    while let Some(character) = bus.receiver.next() {
        let heard = now.of_stamp(character.stamp);
        match character.byte() {
            Err(receiver::Damaged) => shared.port.line_error(heard),
            Ok(byte) => {
                if let Some(answer) = shared.port.receive_byte(heard, byte) {
                    bus.transmitter.send_at(heard.after(bus.answer_delay), answer);
                    #[cfg(feature = "rp2040")]
                    if let Some(piece) = shared.port.take_piece() {
                        crate::inbox::keep_piece(piece);
                    }
                }
            }
        }
    }
    if bus.receiver.is_listening() {
        shared.liveness.bus_ran();
    }
}

/// The transmitter's alarm has gone off.
pub fn on_answer_alarm() {
    let alone = alone();
    within(&alone, |bus| {
        let Some(sent) = bus.transmitter.on_alarm() else { return };
        shared::within(&alone, |shared| {
            if let Some(baud) = shared.port.answer_sent(sent) {
                bus.set_baud(baud);
            }
        });
    });
}

/// Goes back to the line rate that the board was compiled for, if it must. To be called once a
/// control step.
pub fn look_after_line_rate() {
    let now = shared::now();
    cortex_m::interrupt::free(|masked| {
        within(masked, |bus| {
            // A rate that changed now would spoil the answer.
            if bus.transmitter.is_silent()
                && let Some(baud) = shared::within(masked, |shared| shared.port.line_rate_due(now))
            {
                bus.set_baud(baud);
            }
        });
    });
}

impl Bus {
    /// What is being received is lost: it is not of this rate. Takes 15 bits' time, in which nobody
    /// speaks to this board.
    #[inline(never)]
    fn set_baud(&mut self, baud: Baud) {
        self.uart.set_baudrate(baud.get());
        self.transmitter.set_baud(baud);
    }
}

fn within(masked: &CriticalSection, action: impl FnOnce(&mut Bus)) {
    if let Some(bus) = BUS.borrow(masked).borrow_mut().as_mut() {
        action(bus);
    }
}

/// For the two handlers here, which need not mask anything: they run at the highest priority, on
/// the one core that is used.
fn alone() -> CriticalSection {
    // SAFETY: called in those two handlers only. Nothing interrupts them, and they cannot have
    // interrupted anybody who uses what is shared, since all interrupts are masked meanwhile.
    unsafe { CriticalSection::new() }
}
