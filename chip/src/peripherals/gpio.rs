//! IO_BANK0 (2.19): function and overrides of each pin, and the pin interrupts of processor 0.

use super::{RegisterWrite, Written};

/// Register offsets (2.19.6.1). GPIO0_STATUS and GPIO0_CTRL alternate up to pin 29.
const PINS_END: u32 = 0xf0;
const INTR0: u32 = 0x0f0;
const INTR3: u32 = 0x0fc;
const PROC0_INTE0: u32 = 0x100;
const PROC0_INTE3: u32 = 0x10c;
const PROC0_INTF0: u32 = 0x110;
const PROC0_INTF3: u32 = 0x11c;
const PROC0_INTS0: u32 = 0x120;
const PROC0_INTS3: u32 = 0x12c;
const PROC1_INTE0: u32 = 0x130;
const PROC1_INTS3: u32 = 0x15c;
const DORMANT_WAKE_INTE0: u32 = 0x160;
const DORMANT_WAKE_INTE3: u32 = 0x16c;

/// Pins of bank 0.
pub(crate) const PINS: usize = 30;

/// FUNCSEL (2.19.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Uart,
    I2c,
    Pwm,
    Sio,
    /// SPI, PIO, clocks, USB, none: drives nothing here.
    Other,
}

/// The interrupt bits of a pin within INTR (2.19.3).
const LEVEL_LOW: u32 = 1 << 0;
const LEVEL_HIGH: u32 = 1 << 1;
const EDGE_LOW: u32 = 1 << 2;
const EDGE_HIGH: u32 = 1 << 3;
const EDGES: u32 = 0xcccc_cccc;

/// What a field of two override bits makes of a signal.
fn overridden(select: u32, signal: bool) -> bool {
    match select & 3 {
        0 => signal,
        1 => !signal,
        2 => false,
        _ => true,
    }
}

/// The IO_BANK0 block.
#[derive(Clone, Debug)]
pub(crate) struct IoBank {
    control: [u32; PINS],
    /// Latched edges.
    edges: [u32; 4],
    enable: [u32; 4],
    force: [u32; 4],
    /// DORMANT_WAKE_INTE0 to 3: stored, since the chip is never dormant here.
    dormant_wake: [u32; 4],
    /// Levels as the interrupts see them.
    levels: u32,
}

impl Default for IoBank {
    fn default() -> Self {
        IoBank {
            control: [0x1f; PINS],
            edges: [0; 4],
            enable: [0; 4],
            force: [0; 4],
            dormant_wake: [0; 4],
            levels: 0,
        }
    }
}

impl IoBank {
    pub fn reset(&mut self) {
        *self = IoBank { levels: self.levels, ..IoBank::default() };
    }

    pub fn function(&self, pin: usize) -> Function {
        match self.control[pin] & 0x1f {
            2 => Function::Uart,
            3 => Function::I2c,
            4 => Function::Pwm,
            5 => Function::Sio,
            _ => Function::Other,
        }
    }

    /// A peripheral's output after OUTOVER.
    pub fn output(&self, pin: usize, signal: bool) -> bool {
        overridden(self.control[pin] >> 8, signal)
    }

    /// A peripheral's output enable after OEOVER.
    pub fn output_enable(&self, pin: usize, signal: bool) -> bool {
        overridden(self.control[pin] >> 12, signal)
    }

    /// The pin's level after INOVER.
    pub fn input(&self, pin: usize, level: bool) -> bool {
        overridden(self.control[pin] >> 16, level)
    }

    /// The pins' input levels as last set.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// The pins' input levels changed.
    pub fn set_levels(&mut self, levels: u32) {
        let mut changed = levels ^ self.levels;
        while changed != 0 {
            let pin = changed.trailing_zeros();
            changed &= changed - 1;
            let edge = if levels >> pin & 1 != 0 { EDGE_HIGH } else { EDGE_LOW };
            self.edges[(pin / 8) as usize] |= edge << (4 * (pin % 8));
        }
        self.levels = levels;
    }

    fn raw(&self, register: usize) -> u32 {
        let levels = (0..8).filter(|i| 8 * register + i < PINS).map(|i| {
            let high = self.levels >> (8 * register + i) & 1 != 0;
            (if high { LEVEL_HIGH } else { LEVEL_LOW }) << (4 * i)
        });
        self.edges[register] | levels.sum::<u32>()
    }

    fn status(&self, register: usize) -> u32 {
        self.raw(register) & self.enable[register] | self.force[register]
    }

    /// The interrupt line IO_IRQ_BANK0.
    pub fn interrupt(&self) -> bool {
        (0..4).any(|register| self.enable[register] | self.force[register] != 0 && self.status(register) != 0)
    }

    /// Pins with an interrupt enabled: their edges have to be seen as they happen.
    pub fn interrupt_pins(&self) -> u32 {
        (0..PINS)
            .filter(|pin| self.enable[pin / 8] >> (4 * (pin % 8)) & 0xf != 0)
            .fold(0, |set, pin| set | 1 << pin)
    }

    /// `outputs`, `output_enables`: what the pins drive, for GPIOn_STATUS.
    pub fn read(&self, offset: u32, outputs: u32, output_enables: u32) -> Option<u32> {
        let register = (offset / 4 % 4) as usize;
        Some(match offset {
            0..PINS_END if offset & 4 != 0 => self.control[(offset / 8) as usize],
            0..PINS_END => {
                let pin = offset / 8;
                let bit = |set: u32| set >> pin & 1;
                bit(outputs) << 9
                    | bit(output_enables) << 13
                    | bit(self.levels) << 17
                    | bit(self.levels) << 19
            }
            INTR0..=INTR3 => self.raw((offset / 4 % 4) as usize),
            PROC0_INTE0..=PROC0_INTE3 => self.enable[register],
            PROC0_INTF0..=PROC0_INTF3 => self.force[register],
            PROC0_INTS0..=PROC0_INTS3 => self.status(register),
            PROC1_INTE0..=PROC1_INTS3 => 0,
            DORMANT_WAKE_INTE0..=DORMANT_WAKE_INTE3 => self.dormant_wake[register],
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        let register = (offset / 4 % 4) as usize;
        match offset {
            0..PINS_END if offset & 4 != 0 => {
                let control = &mut self.control[(offset / 8) as usize];
                *control = write.onto(*control) & 0x3003_331f;
                // IRQOVER.
                if *control >> 28 != 0 {
                    return Written::ValueNotModelled;
                }
            }
            INTR0..=INTR3 => self.edges[register] &= !(write.ones() & EDGES),
            PROC0_INTE0..=PROC0_INTE3 => self.enable[register] = write.onto(self.enable[register]),
            PROC0_INTF0..=PROC0_INTF3 => self.force[register] = write.onto(self.force[register]),
            0..PINS_END | PROC0_INTS0..=PROC0_INTS3 => {}
            DORMANT_WAKE_INTE0..=DORMANT_WAKE_INTE3 => {
                self.dormant_wake[register] = write.onto(self.dormant_wake[register]);
            }
            // Nobody would see an interrupt to core 1.
            PROC1_INTE0..=PROC1_INTS3 if write.onto(0) == 0 => {}
            PROC1_INTE0..=PROC1_INTS3 => return Written::ValueNotModelled,
            _ => return Written::NotModelled,
        }
        Written::Done
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::peripherals::Alias;

    #[test]
    fn edges_latch_until_acknowledged_and_levels_do_not() {
        let mut io = IoBank::default();
        let pin_9 = 4;
        assert_eq!(io.write(PROC0_INTE0 + 4, RegisterWrite::plain(EDGE_HIGH << pin_9)), Written::Done);
        io.set_levels(1 << 9);
        assert!(io.interrupt());
        io.set_levels(0);
        assert!(io.interrupt(), "latched");
        assert_eq!(io.write(INTR0 + 4, RegisterWrite::plain(EDGE_HIGH << pin_9)), Written::Done);
        assert!(!io.interrupt());
        assert_eq!(io.write(PROC0_INTE0 + 4, RegisterWrite::plain(LEVEL_HIGH << pin_9)), Written::Done);
        assert!(!io.interrupt());
        io.set_levels(1 << 9);
        assert!(io.interrupt());
        assert_eq!(io.write(INTR0 + 4, RegisterWrite::plain(0xf << pin_9)), Written::Done);
        assert!(io.interrupt(), "a level cannot be acknowledged");
        io.set_levels(0);
        assert!(!io.interrupt());
    }

    #[test]
    fn wake_enables_are_stored_and_interrupts_to_core_1_refused() {
        let mut io = IoBank::default();
        assert_eq!(io.write(DORMANT_WAKE_INTE0 + 4, RegisterWrite::plain(0xf0)), Written::Done);
        assert_eq!(io.read(DORMANT_WAKE_INTE0 + 4, 0, 0), Some(0xf0));
        let clear = RegisterWrite { raw: 0xf, alias: Alias::Clear };
        assert_eq!(io.write(PROC1_INTE0, clear), Written::Done);
        assert_eq!(io.write(PROC1_INTE0, RegisterWrite::plain(1)), Written::ValueNotModelled);
    }

    #[test]
    fn functions_and_overrides_come_from_ctrl() {
        let mut io = IoBank::default();
        let control_of_6 = 8 * 6 + 4;
        assert_eq!(io.function(6), Function::Other);
        assert_eq!(io.write(control_of_6, RegisterWrite::plain(4)), Written::Done);
        assert_eq!(io.function(6), Function::Pwm);
        let invert_output = RegisterWrite { raw: 1 << 8, alias: Alias::Set };
        assert_eq!(io.write(control_of_6, invert_output), Written::Done);
        assert!(io.output(6, false) && !io.output(6, true));
        assert_eq!(io.function(6), Function::Pwm);
    }
}
