//! The peripherals, one a file, with the register names of the RP2040 datasheet; each names the
//! section that describes it.
//!
//! A peripheral knows its own registers and the time, nothing of the bus: reads return `None` for a
//! register that is not modelled, writes a [`Written`], and the bus reports both. Counters are
//! computed from the time they started, so a peripheral costs nothing between the events it
//! announces with `next_event`.

pub(crate) mod adc;
pub(crate) mod clocks;
pub(crate) mod dma;
pub(crate) mod gpio;
pub(crate) mod i2c;
pub(crate) mod pads;
pub(crate) mod pll;
pub(crate) mod psm;
pub(crate) mod pwm;
pub(crate) mod resets;
pub(crate) mod rosc;
pub(crate) mod serial_flash;
pub(crate) mod sio;
pub(crate) mod ssi;
pub(crate) mod storage;
pub(crate) mod timer;
pub(crate) mod uart;
pub(crate) mod vreg;
pub(crate) mod watchdog;
pub(crate) mod xip;
pub(crate) mod xosc;

/// Which of the four atomic aliases a register write went through (2.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Alias {
    Plain,
    Xor,
    Set,
    Clear,
}

/// A write to a peripheral register as the peripheral sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegisterWrite {
    pub raw: u32,
    pub alias: Alias,
}

impl RegisterWrite {
    /// The alias is in bits 13 and 12 of the address.
    pub fn new(address: u32, raw: u32) -> RegisterWrite {
        let alias = match address >> 12 & 3 {
            0 => Alias::Plain,
            1 => Alias::Xor,
            2 => Alias::Set,
            _ => Alias::Clear,
        };
        RegisterWrite { raw, alias }
    }

    pub fn plain(raw: u32) -> RegisterWrite {
        RegisterWrite { raw, alias: Alias::Plain }
    }

    /// What an ordinary read/write register holds afterwards if it held `old`.
    pub fn onto(self, old: u32) -> u32 {
        match self.alias {
            Alias::Plain => self.raw,
            Alias::Xor => old ^ self.raw,
            Alias::Set => old | self.raw,
            Alias::Clear => old & !self.raw,
        }
    }

    /// The same for a register of which only the bits in `writable` can be written.
    pub fn onto_bits(self, old: u32, writable: u32) -> u32 {
        old & !writable | self.onto(old) & writable
    }

    /// The bits that act: of write-one-to-clear and self-clearing registers. The value as it is on
    /// the bus, whatever the alias; the SDK acknowledges interrupts both by plain writes and
    /// through the clear alias.
    pub fn ones(self) -> u32 {
        self.raw
    }
}

/// What became of a register write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub(crate) enum Written {
    Done,
    /// No such register here.
    NotModelled,
    /// The register is here, but not what this value asks for.
    ValueNotModelled,
}
