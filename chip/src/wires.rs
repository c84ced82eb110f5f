//! What is outside the package: pins, serial lines, voltages.

use std::any::Any;

use crate::bus::{Edge, Level};
use crate::chip::Chip;
use crate::parts::I2cPart;
use crate::peripherals::adc::Conversions;
use crate::peripherals::uart::{LineErrors, Transmitted};
use crate::ticks::Ticks;

/// Pins of the package, GPIO0 to GPIO29.
pub const PINS: usize = 30;

impl Chip {
    /// Puts a character on the line into UART `uart` (0 or 1). The UART has it from `stop_bit_at`
    /// on, the tick at which it samples the stop bit; a time already past means as soon as the chip
    /// runs on. The UART ignores it if it is off or no pin is switched to its RX.
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

    /// The characters UART `uart` has begun to send since the last call, in order; the last one may
    /// not have ended. The times follow from UARTIBRD, UARTFBRD and clk_peri, without accumulated
    /// rounding. Only what left through a pin is there.
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

    /// Chooses the pins, bit n for pin n, whose level changes are logged from now on. A watched PWM
    /// pin costs an event an edge. The levels within a character on a UART pin are not logged: see
    /// [`Chip::take_transmitted`].
    pub fn watch_pins(&mut self, pins: u32) {
        self.bus.watch_pins(pins);
    }

    /// The level changes of the watched pins since the last call, in order of time.
    pub fn take_pin_edges(&mut self) -> Vec<Edge> {
        self.bus.take_edges()
    }

    /// The part of its period a PWM pin is high, 0 to 1, by the values in effect now. None if the
    /// pin is not switched to PWM.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pwm_duty(&self, pin: usize) -> Option<f64> {
        let (slice, channel_b) = self.bus.pwm.slice_of(pin);
        self.bus.is_pwm_pin(pin).then(|| slice.duty(channel_b, self.bus.now))
    }

    /// The period of a PWM pin; [`Ticks::NEVER`] while its slice stands still, none if it is not
    /// switched to PWM.
    ///
    /// # Panics
    ///
    /// If there is no such pin.
    pub fn pwm_period(&self, pin: usize) -> Option<Ticks> {
        let (slice, _) = self.bus.pwm.slice_of(pin);
        self.bus.is_pwm_pin(pin).then(|| slice.period_ticks())
    }

    /// Wires SDA and SCL of an I2C bus, with pull-ups, to two pins. It belongs to the I2C block
    /// that these pins can be switched to: block 0 on GPIO 0 and 1, 4 and 5, .., block 1 on 2 and
    /// 3, 6 and 7, ... Parts come with [`Chip::attach_i2c`].
    ///
    /// # Panics
    ///
    /// If the two are not SDA and SCL of the same block.
    pub fn wire_i2c(&mut self, sda: usize, scl: usize) {
        self.bus.wire_i2c(sda, scl);
    }

    /// Puts a part on the bus of I2C block `block` (0 or 1), as it is after power-on. Gives the one
    /// that had the address.
    ///
    /// # Panics
    ///
    /// If there is no such block, no bus is wired to it, or the address has more than 7 bits.
    pub fn attach_i2c(&mut self, block: usize, address: u8, part: impl I2cPart) -> Option<Box<dyn I2cPart>> {
        assert!(address < 0x80, "addresses have 7 bits");
        assert!(self.bus.i2c[block].wires.pins().is_some(), "wire_i2c comes first");
        self.bus.i2c[block].wires.attach(address, Box::new(part))
    }

    /// Takes a part off. In the middle of a transfer it does not acknowledge any more, and sends
    /// ones.
    ///
    /// # Panics
    ///
    /// If there is no such block.
    pub fn detach_i2c(&mut self, block: usize, address: u8) -> Option<Box<dyn I2cPart>> {
        self.bus.i2c[block].wires.detach(address)
    }

    /// The part with this address, to be told what it measures; none if there is none, or one of
    /// another type.
    ///
    /// # Panics
    ///
    /// If there is no such block.
    pub fn i2c_part<P: I2cPart>(&mut self, block: usize, address: u8) -> Option<&mut P> {
        let part: &mut dyn Any = self.bus.i2c[block].wires.part_mut(address)?;
        part.downcast_mut()
    }

    /// A part on the bus pulls SDA low until SCL has gone high `clocks` times: what one does that
    /// was left in the middle of a byte. 0 makes it let go. For a line that is low for ever there
    /// is [`Chip::set_pin_input`].
    ///
    /// A transfer that is going on loses arbitration at the end of its byte; the next one waits
    /// until the line is free.
    ///
    /// # Panics
    ///
    /// If there is no such block.
    pub fn hold_i2c_sda(&mut self, block: usize, clocks: u32) {
        self.bus.hold_sda(block, clocks);
    }

    /// The voltage at an ADC input from now on, in counts: 0 to 4095 for 0 to ADC_AVDD, more is cut
    /// off as by the converter. Channels 0 to 3 are GPIO26 to 29, 4 is the temperature sensor (876
    /// at power-on, 27 degrees Celsius).
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
