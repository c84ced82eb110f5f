//! One DMA channel (2.5.2): addresses, count, control, and the four orders its registers appear in.

use crate::peripherals::{RegisterWrite, Written};

/// CTRL.
const EN: u32 = 1 << 0;
const HIGH_PRIORITY: u32 = 1 << 1;
const INCR_READ: u32 = 1 << 4;
const INCR_WRITE: u32 = 1 << 5;
const RING_SEL: u32 = 1 << 10;
const IRQ_QUIET: u32 = 1 << 21;
const BSWAP: u32 = 1 << 22;
const SNIFF_EN: u32 = 1 << 23;
const BUSY: u32 = 1 << 24;
const WRITE_ERROR: u32 = 1 << 29;
const READ_ERROR: u32 = 1 << 30;
const AHB_ERROR: u32 = 1 << 31;
const WRITABLE: u32 = 0x00ff_ffff;

/// Credits a channel can hold for pulse requests (2.5.3: the counter has six bits).
pub(super) const MAX_CREDIT: u64 = 63;

/// One of the four registers of a channel.
#[derive(Clone, Copy, PartialEq)]
enum Field {
    ReadAddress,
    WriteAddress,
    Count,
    Control,
}

/// The register at an offset, by alias block; the last of each block triggers (2.5.2.1).
const LAYOUT: [[Field; 4]; 4] = {
    use Field::{Control, Count, ReadAddress, WriteAddress};
    [
        [ReadAddress, WriteAddress, Count, Control],
        [Control, ReadAddress, WriteAddress, Count],
        [Control, Count, ReadAddress, WriteAddress],
        [Control, WriteAddress, Count, ReadAddress],
    ]
};

/// A data movement to make now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Transfer {
    pub from: u32,
    pub to: u32,
    /// Bytes: 1, 2 or 4.
    pub size: u32,
    /// Reverse the bytes.
    pub swap: bool,
}

/// Which side of a transfer the bus refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TransferError {
    Read,
    Write,
}

/// One channel.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    number: usize,
    read_address: u32,
    write_address: u32,
    /// Transfers left of the present sequence.
    remaining: u32,
    /// TRANS_COUNT as written: what the next trigger starts from.
    reload: u32,
    control: u32,
    busy: bool,
    credit: u64,
    interrupt: bool,
}

impl Channel {
    pub fn new(number: usize) -> Channel {
        Channel {
            number,
            read_address: 0,
            write_address: 0,
            remaining: 0,
            reload: 0,
            // CHAIN_TO itself: no chaining.
            control: (number as u32) << 11,
            busy: false,
            credit: 0,
            interrupt: false,
        }
    }

    pub fn is_busy(&self) -> bool {
        self.busy && self.control & EN != 0
    }

    pub fn is_high_priority(&self) -> bool {
        self.control & HIGH_PRIORITY != 0
    }

    /// TREQ_SEL.
    pub fn request(&self) -> u32 {
        self.control >> 15 & 0x3f
    }

    pub fn has_credit(&self) -> bool {
        self.credit > 0
    }

    pub fn add_credit(&mut self, request: u32) {
        if self.is_busy() && self.request() == request {
            self.credit = (self.credit + 1).min(MAX_CREDIT);
        }
    }

    /// The interrupt it has raised since the last call.
    pub fn take_interrupt(&mut self) -> bool {
        std::mem::take(&mut self.interrupt)
    }

    pub fn read(&self, offset: u32) -> u32 {
        match LAYOUT[(offset / 16) as usize][(offset / 4 % 4) as usize] {
            Field::ReadAddress => self.read_address,
            Field::WriteAddress => self.write_address,
            Field::Count => self.remaining,
            Field::Control => self.control | if self.busy { BUSY } else { 0 },
        }
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite) -> Written {
        let (block, position) = ((offset / 16) as usize, (offset / 4 % 4) as usize);
        let field = LAYOUT[block][position];
        let value = match field {
            Field::ReadAddress => {
                self.read_address = write.onto(self.read_address);
                self.read_address
            }
            Field::WriteAddress => {
                self.write_address = write.onto(self.write_address);
                self.write_address
            }
            Field::Count => {
                self.reload = write.onto(self.reload);
                if !self.busy {
                    self.remaining = self.reload;
                }
                self.reload
            }
            Field::Control => {
                let errors = self.control & (READ_ERROR | WRITE_ERROR) & !write.ones();
                self.control = write.onto(self.control) & WRITABLE | errors;
                if errors != 0 {
                    self.control |= AHB_ERROR;
                }
                self.control & WRITABLE
            }
        };
        if position == 3 {
            // A zero written to a trigger register is a null trigger: it ends a chain of control
            // blocks (2.5.2.3).
            if value != 0 {
                self.trigger();
            } else if self.control & IRQ_QUIET != 0 {
                self.interrupt = true;
            }
        }
        if field == Field::Control && self.control & SNIFF_EN != 0 {
            Written::ValueNotModelled
        } else {
            Written::Done
        }
    }

    /// Starts a sequence of transfers, unless the channel is busy or disabled.
    pub fn trigger(&mut self) {
        if self.busy || self.control & EN == 0 {
            return;
        }
        self.remaining = self.reload;
        self.credit = 0;
        self.busy = self.remaining > 0;
        if !self.busy {
            self.interrupt |= self.control & IRQ_QUIET == 0;
        }
    }

    /// CHAN_ABORT (2.5.5.3): nothing is in flight here, so it stops at once and without the
    /// spurious interrupt of erratum RP2040-E13.
    pub fn abort(&mut self) {
        self.busy = false;
        self.remaining = 0;
    }

    /// The transfer to make next.
    pub fn transfer(&self) -> Transfer {
        Transfer {
            from: self.read_address,
            to: self.write_address,
            size: self.size(),
            swap: self.control & BSWAP != 0,
        }
    }

    fn size(&self) -> u32 {
        match self.control >> 2 & 3 {
            0 => 1,
            1 => 2,
            _ => 4,
        }
    }

    /// A transfer failed: the channel halts.
    pub fn fail(&mut self, error: TransferError) {
        self.busy = false;
        self.control |= AHB_ERROR;
        self.control |= match error {
            TransferError::Read => READ_ERROR,
            TransferError::Write => WRITE_ERROR,
        };
    }

    /// Accounts for one transfer. Returns CHAIN_TO when it was the last of the sequence.
    pub fn complete(&mut self) -> Option<usize> {
        self.credit = self.credit.saturating_sub(1);
        let ring_bits = self.control >> 6 & 15;
        let (read_ring, write_ring) =
            if self.control & RING_SEL != 0 { (0, ring_bits) } else { (ring_bits, 0) };
        if self.control & INCR_READ != 0 {
            self.read_address = advance(self.read_address, self.size(), read_ring);
        }
        if self.control & INCR_WRITE != 0 {
            self.write_address = advance(self.write_address, self.size(), write_ring);
        }
        self.remaining -= 1;
        if self.remaining > 0 {
            return None;
        }
        self.busy = false;
        self.interrupt |= self.control & IRQ_QUIET == 0;
        let chain_to = (self.control >> 11 & 15) as usize;
        (chain_to != self.number).then_some(chain_to)
    }
}

/// The next address; with a ring only its lower `ring_bits` bits change.
fn advance(address: u32, size: u32, ring_bits: u32) -> u32 {
    let next = address.wrapping_add(size);
    if ring_bits == 0 {
        return next;
    }
    let mask = (1 << ring_bits) - 1;
    address & !mask | next & mask
}
