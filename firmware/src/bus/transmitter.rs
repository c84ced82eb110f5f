//! Sends an answer at its time, and holds the driver enable pin high until its last stop bit.

use crate::chip::{ANSWER_TIMER_IRQ, TIMER};
use embassy_rp::gpio::Output;
use embassy_rp::interrupt::InterruptExt;
use embassy_rp::pac::UART0;
use pneudrive_control::{Answer, Micros};
use pneudrive_protocol::Baud;

/// Alarm of the timer; Embassy uses alarm 0.
const ALARM: usize = 1;
/// Distance of looks at a UART that is still busy.
const BUSY_TIME: Micros = Micros::new(1);

/// Moves one answer at a time, from alarm to alarm.
pub struct Transmitter {
    state: State,
    /// Time of an answer on the wire.
    answer_time: Micros,
    driver_enable: Output<'static>,
}

enum State {
    Silent,
    Waiting(Answer),
    Sending { look_again: Micros },
}

impl Transmitter {
    /// Silent, with the driver off.
    pub fn new(driver_enable: Output<'static>, baud: Baud) -> Self {
        TIMER.inte().modify(|w| w.set_alarm(ALARM, true));
        let mut transmitter = Self { state: State::Silent, answer_time: Micros::ZERO, driver_enable };
        transmitter.set_baud(baud);
        transmitter
    }

    /// The UART sends at this rate from now on.
    pub fn set_baud(&mut self, baud: Baud) {
        self.answer_time = Micros::new(baud.packet_ns().div_ceil(1_000));
    }

    /// Whether no answer waits or is being sent.
    pub fn is_silent(&self) -> bool {
        matches!(self.state, State::Silent)
    }

    /// Sends `answer` at time `due`, or at once if that has passed.
    pub fn send_at(&mut self, due: Micros, answer: Answer) {
        self.state = State::Waiting(answer);
        set_alarm(due);
    }

    /// The alarm has gone off; gives the time at which the UART was seen to have sent an answer's
    /// last stop bit.
    pub fn on_alarm(&mut self) -> Option<Micros> {
        TIMER.intr().write(|w| w.set_alarm(ALARM, true));
        let now = crate::shared::now();
        match self.state {
            State::Silent => {}
            State::Waiting(answer) => {
                self.driver_enable.set_high();
                // The FIFO holds 32 bytes, so all ten go in at once and come out back to back.
                for byte in answer {
                    UART0.uartdr().write(|w| w.set_data(byte));
                }
                self.look_again_at(now.after(self.answer_time));
            }
            State::Sending { look_again } if now < look_again => set_alarm(look_again),
            State::Sending { .. } if UART0.uartfr().read().busy() => self.look_again_at(now.after(BUSY_TIME)),
            State::Sending { .. } => {
                self.driver_enable.set_low();
                self.state = State::Silent;
                return Some(now);
            }
        }
        None
    }

    fn look_again_at(&mut self, look_again: Micros) {
        self.state = State::Sending { look_again };
        set_alarm(look_again);
    }
}

/// Sets the alarm. An alarm whose time has passed would not go off for 71 minutes (datasheet
/// 4.6.3), so its interrupt is then raised by hand.
fn set_alarm(at: Micros) {
    TIMER.alarm(ALARM).write_value(at.get() as u32);
    if crate::shared::now() >= at {
        ANSWER_TIMER_IRQ.pend();
    }
}
