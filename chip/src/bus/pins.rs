//! What stands on the pins: who drives them, the pulls, the outside, and the log of edges.

use super::Bus;
use crate::peripherals::gpio::{Function, PINS};
use crate::peripherals::i2c::I2c;
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
    /// Pins that are switched to I2C or wired to a bus.
    i2c_pins: u32,
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
            i2c_pins: 0,
        }
    }
}

impl PinState {
    pub fn uart_receives(&self, uart: usize) -> bool {
        self.receive_pins[uart]
    }
}

/// UART and signal of a pin with the UART function (2.19.2): TX, RX, CTS, RTS repeat every four
/// pins.
fn uart_signal(pin: usize) -> (usize, usize) {
    const UARTS: [usize; 8] = [0, 1, 1, 0, 0, 1, 1, 0];
    (UARTS[pin / 4], pin % 4)
}

/// I2C block and signal of a pin with the I2C function (2.19.2): SDA and SCL of block 0, then of
/// block 1.
fn i2c_signal(pin: usize) -> (usize, usize) {
    (pin / 2 % 2, pin % 2)
}

/// What an I2C bus puts on a pin, if it is wired to it.
fn wire_level(i2c: &I2c, pin: usize) -> Option<Level> {
    let [sda, scl] = i2c.wires.pins()?;
    match pin {
        _ if pin == sda => Some((!i2c.wires.holds_sda()).into()),
        _ if pin == scl => Some(Level::High),
        _ => None,
    }
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
            // The levels within a transfer are not modelled.
            Function::I2c | Function::Other => (false, false),
        };
        if !self.io.output_enable(pin, enable) || self.pads.output_disabled(pin) {
            return Level::Floating;
        }
        self.io.output(pin, signal).into()
    }

    /// What stands on a pin. The chip's driver wins over the outside, the outside over the pulls.
    pub fn pin_level(&self, pin: usize, at: Ticks) -> Level {
        match (self.pin_output(pin, at), self.outside_level(pin)) {
            (Level::Floating, Level::Floating) => self.pads.pull(pin).map_or(Level::Floating, Level::from),
            (Level::Floating, outside) => outside,
            (driven, _) => driven,
        }
    }

    /// What the outside puts on a pin: what it was told to, else what an I2C bus there does with
    /// its pull-ups and parts.
    fn outside_level(&self, pin: usize) -> Level {
        match self.pins.outside[pin] {
            Level::Floating => {
                self.i2c.iter().find_map(|i2c| wire_level(i2c, pin)).unwrap_or(Level::Floating)
            }
            told => told,
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

    /// Looks at these pins: hands changed inputs to the pin interrupts, changed levels of watched
    /// pins to the log.
    pub(super) fn update_some_pins(&mut self, pins: u32, at: Ticks) {
        let pins = pins | self.clock_i2c_wires(pins, at);
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
        if pins & self.pins.i2c_pins != 0 {
            self.update_i2c_lines(at);
        }
    }

    /// Hands SCL of the I2C buses to their parts. Gives the pins that change with it, bit n for pin
    /// n.
    fn clock_i2c_wires(&mut self, pins: u32, at: Ticks) -> u32 {
        let mut changed = 0;
        for n in 0..self.i2c.len() {
            let Some([sda, scl]) = self.i2c[n].wires.pins().filter(|[_, scl]| pins >> scl & 1 != 0) else {
                continue;
            };
            let high = self.pin_level(scl, at) == Level::High;
            if self.i2c[n].wires.clock(high) {
                changed |= 1 << sda;
            }
        }
        changed
    }

    /// Tells the I2C blocks whether their lines are free: high at some pin each that is switched to
    /// them.
    fn update_i2c_lines(&mut self, at: Ticks) {
        for n in 0..self.i2c.len() {
            let high = |signal: usize| {
                let mut pins = (0..PINS)
                    .filter(|pin| self.io.function(*pin) == Function::I2c && i2c_signal(*pin) == (n, signal));
                pins.any(|pin| self.input_level(pin, at))
            };
            let free = high(0) && high(1);
            let wired = self.i2c[n].wires.pins();
            let connected =
                wired.is_some_and(|pins| pins.iter().all(|pin| self.io.function(*pin) == Function::I2c));
            self.i2c[n].wires.connect(connected);
            self.i2c[n].set_lines_free(free, at);
        }
    }

    /// Wires SDA and SCL of an I2C bus with pull-ups to these pins; the block is the one that they
    /// can be switched to.
    pub fn wire_i2c(&mut self, sda: usize, scl: usize) {
        let (block, signal) = i2c_signal(sda);
        assert!(
            signal == 0 && i2c_signal(scl) == (block, 1),
            "GPIO{sda} and GPIO{scl} are no SDA and SCL of a block"
        );
        self.i2c[block].wires.wire(sda, scl);
        self.pin_functions_changed();
        self.outside_changed();
    }

    /// A part pulls SDA of this bus low until SCL has gone high so many times.
    pub fn hold_sda(&mut self, block: usize, clocks: u32) {
        self.i2c[block].wires.hold_sda(clocks);
        self.update_pins();
        self.outside_changed();
    }

    /// A pin's function, or its interrupt enables, changed.
    pub(super) fn pin_functions_changed(&mut self) {
        let on = |function: Function| {
            (0..PINS).filter(|pin| self.io.function(*pin) == function).fold(0u32, |set, pin| set | 1 << pin)
        };
        let (uart_pins, pwm_pins) = (on(Function::Uart), on(Function::Pwm));
        let wired = self.i2c.iter().filter_map(|i2c| i2c.wires.pins()).flatten();
        self.pins.i2c_pins = on(Function::I2c) | wired.fold(0, |set, pin| set | 1 << pin);
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
