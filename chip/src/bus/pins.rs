//! What stands on the pins: who drives them, the pulls, the outside, and the log of edges.

use super::Bus;
use crate::peripherals::gpio::{Function, PINS};
use crate::ticks::Ticks;

/// Voltage of a pin as far as a digital world knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Ground.
    Low,
    /// The IO supply.
    High,
    /// Nobody drives or pulls it.
    Floating,
}

impl From<bool> for Level {
    fn from(high: bool) -> Level {
        if high { Level::High } else { Level::Low }
    }
}

/// A change of a watched pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// When.
    pub at: Ticks,
    /// Pin number.
    pub pin: u8,
    /// The level from then on.
    pub level: Level,
}

/// Levels driven from outside, and what was last seen.
#[derive(Clone, Debug)]
pub(super) struct PinState {
    outside: [Level; PINS],
    watched: u32,
    seen: [Level; PINS],
    edges: Vec<Edge>,
    /// By UART: some pin is switched to its RX.
    receive_pins: [bool; 2],
    /// PWM pins that are watched or have an interrupt enabled.
    pwm_watched: u32,
}

impl Default for PinState {
    fn default() -> Self {
        PinState {
            outside: [Level::Floating; PINS],
            watched: 0,
            seen: [Level::Floating; PINS],
            edges: Vec::new(),
            receive_pins: [false; 2],
            pwm_watched: 0,
        }
    }
}

impl PinState {
    pub fn uart_receives(&self, uart: usize) -> bool {
        self.receive_pins[uart]
    }
}

/// UART and signal of a pin with the UART function (2.19.2): TX, RX, CTS, RTS repeat every four pins.
fn uart_signal(pin: usize) -> (usize, usize) {
    const UARTS: [usize; 8] = [0, 1, 1, 0, 0, 1, 1, 0];
    (UARTS[pin / 4], pin % 4)
}

impl Bus {
    /// What the chip itself drives onto a pin; floating if its driver is off.
    pub fn pin_output(&self, pin: usize, at: Ticks) -> Level {
        let (signal, enable) = match self.io.function(pin) {
            Function::Sio => (self.sio.output() >> pin & 1 != 0, self.sio.output_enable() >> pin & 1 != 0),
            Function::Pwm => {
                let (slice, channel_b) = self.pwm.slice_of(pin);
                (slice.output(channel_b, at), true)
            }
            Function::Uart => match uart_signal(pin) {
                (uart, 0) => (self.uarts[uart].transmit_line(at), true),
                // RTS without flow control: not asserted, which is high.
                (_, 3) => (true, true),
                _ => (false, false),
            },
            Function::Other => (false, false),
        };
        if !self.io.output_enable(pin, enable) || self.pads.output_disabled(pin) {
            return Level::Floating;
        }
        self.io.output(pin, signal).into()
    }

    /// What stands on a pin. The chip's driver wins over the outside, the outside over the pulls.
    pub fn pin_level(&self, pin: usize, at: Ticks) -> Level {
        match (self.pin_output(pin, at), self.pins.outside[pin]) {
            (Level::Floating, Level::Floating) => self.pads.pull(pin).map_or(Level::Floating, Level::from),
            (Level::Floating, outside) => outside,
            (driven, _) => driven,
        }
    }

    /// Outputs and output enables of all pins, for GPIOn_STATUS.
    pub(super) fn driven_pins(&self) -> (u32, u32) {
        (0..PINS).fold((0, 0), |(outputs, enables), pin| match self.pin_output(pin, self.now) {
            Level::High => (outputs | 1 << pin, enables | 1 << pin),
            Level::Low => (outputs, enables | 1 << pin),
            Level::Floating => (outputs, enables),
        })
    }

    /// What a pin's input buffer hands on, after INOVER. A floating pin reads low.
    fn input_level(&self, pin: usize, at: Ticks) -> bool {
        let high = self.pads.input_enabled(pin) && self.pin_level(pin, at) == Level::High;
        self.io.input(pin, high)
    }

    /// The inputs of all pins, for GPIO_IN.
    pub(super) fn input_levels(&self) -> u32 {
        (0..PINS).fold(0, |inputs, pin| inputs | u32::from(self.input_level(pin, self.now)) << pin)
    }

    /// A level from outside; floating to let go.
    pub fn set_outside_level(&mut self, pin: usize, level: Level) {
        self.pins.outside[pin] = level;
        self.update_pins();
        self.outside_changed();
    }

    /// Something that decides levels changed: looks at all pins.
    pub(super) fn update_pins(&mut self) {
        self.update_some_pins(u32::MAX, self.now);
    }

    /// Looks at the PWM pins that are watched or interrupt.
    pub(super) fn update_pwm_pins(&mut self, at: Ticks) {
        if self.pins.pwm_watched != 0 {
            self.update_some_pins(self.pins.pwm_watched, at);
        }
    }

    /// Looks at these pins: hands changed inputs to the pin interrupts, changed levels of watched pins to the log.
    pub(super) fn update_some_pins(&mut self, pins: u32, at: Ticks) {
        let mut inputs = self.io.levels();
        for pin in (0..PINS).filter(|pin| pins >> pin & 1 != 0) {
            inputs = inputs & !(1 << pin) | u32::from(self.input_level(pin, at)) << pin;
            if self.pins.watched >> pin & 1 != 0 {
                let level = self.pin_level(pin, at);
                if level != self.pins.seen[pin] {
                    self.pins.seen[pin] = level;
                    self.pins.edges.push(Edge { at, pin: pin as u8, level });
                }
            }
        }
        self.io.set_levels(inputs);
    }

    /// A pin's function, or its interrupt enables, changed.
    pub(super) fn pin_functions_changed(&mut self) {
        let on = |function: Function| {
            (0..PINS).filter(|pin| self.io.function(*pin) == function).fold(0u32, |set, pin| set | 1 << pin)
        };
        let (uart_pins, pwm_pins) = (on(Function::Uart), on(Function::Pwm));
        let signals: Vec<_> = (0..PINS).filter(|pin| uart_pins >> pin & 1 != 0).map(uart_signal).collect();
        for (number, uart) in self.uarts.iter_mut().enumerate() {
            uart.set_transmit_pin(signals.contains(&(number, 0)));
            self.pins.receive_pins[number] = signals.contains(&(number, 1));
        }
        let looked_at = pwm_pins & (self.pins.watched | self.io.interrupt_pins());
        self.pins.pwm_watched = looked_at;
        self.pwm.watch_pins(looked_at, self.now);
        self.update_pins();
    }

    /// Logs the edges of these pins from now on, bit n for pin n. See [`crate::Chip::watch_pins`].
    pub fn watch_pins(&mut self, pins: u32) {
        self.pins.watched = pins & ((1 << PINS) - 1);
        for pin in 0..PINS {
            self.pins.seen[pin] = self.pin_level(pin, self.now);
        }
        self.pin_functions_changed();
        self.outside_changed();
    }

    pub fn take_edges(&mut self) -> Vec<Edge> {
        std::mem::take(&mut self.pins.edges)
    }

    /// Whether a pin is switched to PWM.
    pub fn is_pwm_pin(&self, pin: usize) -> bool {
        self.io.function(pin) == Function::Pwm
    }
}
