//! What is outside the package: pins, serial lines, voltages.

use crate::bus::{Edge, Level};
use crate::chip::Chip;
use crate::peripherals::adc::Conversions;
use crate::peripherals::uart::{LineErrors, Transmitted};
use crate::ticks::Ticks;

/// Pins of the package, GPIO0 to GPIO29.
pub const PINS: usize = 30;

impl Chip {
    /// Puts a character on the line into UART `uart` (0 or 1). The UART has it from `stop_bit_at` on, the tick at which
    /// it samples the stop bit; a time already past means as soon as the chip runs on. The UART ignores it if it is
    /// off or no pin is switched to its RX.
    ///
    /// The character is taken as received: whether the sender's baud rate fits is not looked at.
    ///
    /// # Panics
    ///
    /// If there is no such UART.
    pub fn uart_receive(&mut self, uart: usize, stop_bit_at: Ticks, byte: u8, errors: LineErrors) {
        self.bus.uarts[uart].put_on_wire(stop_bit_at.max(self.bus.now), byte, errors);
        self.bus.outside_changed();
    }

    /// The characters UART `uart` has begun to send since the last call, in order; the last one may not have ended. The
    /// times follow from UARTIBRD, UARTFBRD and clk_peri, without accumulated rounding. Only what left through a
    /// pin is there.
    ///
    /// # Panics
    ///
    /// If there is no such UART.
    pub fn take_transmitted(&mut self, uart: usize) -> impl Iterator<Item = Transmitted> + '_ {
        self.bus.uarts[uart].take_transmitted()
    }

    /// Characters UART `uart` has lost to a full FIFO.
    ///
    /// # Panics
    ///
    /// If there is no such UART.
    pub fn uart_overruns(&self, uart: usize) -> u64 {
        self.bus.uarts[uart].overruns()
    }

    /// The line rate that UART `uart`'s divisors make of clk_peri, bit/s, to the nearest; 0 while
    /// either is not set up.
    ///
    /// # Panics
    ///
    /// If there is no such UART.
    pub fn uart_baud(&self, uart: usize) -> u64 {
        self.bus.uarts[uart].baud()
    }

    /// What the outside puts on a pin, from now on.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn set_pin_input(&mut self, pin: usize, level: Level) {
        self.bus.set_outside_level(pin, level);
    }

    /// What stands on a pin now: what the chip drives, else what the outside does, else its pull.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pin_level(&self, pin: usize) -> Level {
        self.bus.pin_level(pin, self.bus.now)
    }

    /// What the chip drives onto a pin now; floating while its driver is off, as after every reset.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pin_output(&self, pin: usize) -> Level {
        self.bus.pin_output(pin, self.bus.now)
    }

    /// Chooses the pins, bit n for pin n, whose level changes are logged from now on. A watched PWM pin costs an event
    /// an edge. The levels within a character on a UART pin are not logged: see [`Chip::take_transmitted`].
    pub fn watch_pins(&mut self, pins: u32) {
        self.bus.watch_pins(pins);
    }

    /// The level changes of the watched pins since the last call, in order of time.
    pub fn take_pin_edges(&mut self) -> Vec<Edge> {
        self.bus.take_edges()
    }

    /// The part of its period a PWM pin is high, 0 to 1, by the values in effect now. None if the pin is not switched
    /// to PWM.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pwm_duty(&self, pin: usize) -> Option<f64> {
        let (slice, channel_b) = self.bus.pwm.slice_of(pin);
        self.bus.is_pwm_pin(pin).then(|| slice.duty(channel_b, self.bus.now))
    }

    /// The period of a PWM pin; [`Ticks::NEVER`] while its slice stands still, none if it is not switched to PWM.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pwm_period(&self, pin: usize) -> Option<Ticks> {
        let (slice, _) = self.bus.pwm.slice_of(pin);
        self.bus.is_pwm_pin(pin).then(|| slice.period_ticks())
    }

    /// The voltage at an ADC input from now on, in counts: 0 to 4095 for 0 to ADC_AVDD, more is cut off as by the
    /// converter. Channels 0 to 3 are GPIO26 to 29, 4 is the temperature sensor (876 at power-on, 27 degrees
    /// Celsius).
    ///
    /// # Panics
    ///
    /// If there is no such channel.
    pub fn set_adc(&mut self, channel: usize, counts: u16) {
        self.bus.adc.set_input(channel, counts.min(4095));
    }

    /// How often an ADC input has been converted, and when it was last sampled.
    ///
    /// # Panics
    ///
    /// If there is no such channel.
    pub fn adc_conversions(&self, channel: usize) -> Conversions {
        self.bus.adc.conversions(channel)
    }
}
