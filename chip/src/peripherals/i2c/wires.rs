//! SDA and SCL outside the chip, with their pull-ups and the parts on them.

use std::collections::BTreeMap;

use crate::parts::I2cPart;
use crate::ticks::Ticks;

/// The bus behind an I2C block.
#[derive(Clone, Debug, Default)]
pub(crate) struct I2cWires {
    /// The pins that it is wired to.
    pins: Option<[usize; 2]>,
    /// These are switched to the block.
    connected: bool,
    parts: BTreeMap<u8, Box<dyn I2cPart>>,
    /// The part that the present transfer is with.
    selected: Option<u8>,
    /// Clock pulses after which a part lets go of SDA; 0 if none holds it.
    held_for: u32,
    scl_was_high: bool,
}

impl I2cWires {
    pub fn wire(&mut self, sda: usize, scl: usize) {
        self.pins = Some([sda, scl]);
        self.scl_was_high = true;
    }

    /// Pins of SDA and SCL.
    pub fn pins(&self) -> Option<[usize; 2]> {
        self.pins
    }

    /// Whether the pins that it is wired to are switched to the block.
    pub fn connect(&mut self, connected: bool) {
        self.connected = connected;
    }

    pub fn attach(&mut self, address: u8, part: Box<dyn I2cPart>) -> Option<Box<dyn I2cPart>> {
        self.parts.insert(address, part)
    }

    pub fn detach(&mut self, address: u8) -> Option<Box<dyn I2cPart>> {
        self.parts.remove(&address)
    }

    pub fn part_mut(&mut self, address: u8) -> Option<&mut dyn I2cPart> {
        self.parts.get_mut(&address).map(Box::as_mut)
    }

    /// A part pulls SDA low until SCL has gone high so many times.
    pub fn hold_sda(&mut self, clocks: u32) {
        self.held_for = clocks;
    }

    pub fn holds_sda(&self) -> bool {
        self.held_for > 0
    }

    /// The level of SCL as it is now. Gives whether SDA changes with it.
    pub fn clock(&mut self, scl: bool) -> bool {
        let rises = scl && !self.scl_was_high;
        self.scl_was_high = scl;
        if rises && self.held_for > 0 {
            self.held_for -= 1;
            return self.held_for == 0;
        }
        false
    }

    fn selected(&mut self) -> Option<&mut Box<dyn I2cPart>> {
        let selected = self.selected.filter(|_| self.connected)?;
        self.parts.get_mut(&selected)
    }

    /// A START or repeated START. Gives whether somebody acknowledges.
    pub fn start(&mut self, now: Ticks, address: u8, read: bool) -> bool {
        self.selected = Some(address);
        let acknowledged = self.selected().is_some_and(|part| part.start(now, read));
        if !acknowledged {
            self.selected = None;
        }
        acknowledged
    }

    /// A part that was taken off meanwhile does not acknowledge.
    pub fn write(&mut self, now: Ticks, byte: u8) -> bool {
        self.selected().is_some_and(|part| part.write(now, byte))
    }

    /// Without a part the pull-up sends ones.
    pub fn read(&mut self, now: Ticks) -> u8 {
        self.selected().map_or(0xff, |part| part.read(now))
    }

    pub fn stop(&mut self, now: Ticks) {
        if let Some(part) = self.selected() {
            part.stop(now);
        }
        self.selected = None;
    }

    /// The transfer ends without a STOP.
    pub fn abandon(&mut self) {
        self.selected = None;
    }
}
