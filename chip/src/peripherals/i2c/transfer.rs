//! What happens on the bus, byte by byte.

use super::registers::{
    ABRT_7B_ADDR_NOACK, ABRT_TXDATA_NOACK, ACTIVITY, ARB_LOST, RESTART_DET, RESTART_EN, RX_OVER, START_DET,
    STOP_DET, TX_ABRT,
};
use super::{FIFO_DEPTH, I2c};
use crate::ticks::Ticks;

/// Where a transfer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Idle,
    /// SCL is held low until there is a command, after one that read or wrote.
    Waiting {
        read: bool,
    },
    Busy {
        work: Work,
        from: Ticks,
        until: Ticks,
    },
}

/// What is on the wires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// START or repeated START, address, acknowledgement.
    Address {
        read: bool,
    },
    Write {
        byte: u8,
        stop: bool,
    },
    Read {
        byte: u8,
        stop: bool,
    },
    Stop,
}

/// Bits of a byte with its acknowledgement; START and STOP are taken to last a bit.
const BYTE_BITS: u64 = 9;
const ADDRESS_BITS: u64 = 1 + BYTE_BITS;

impl Phase {
    /// Something is in the shift register.
    pub fn shifts(self) -> bool {
        matches!(
            self,
            Phase::Busy { work: Work::Address { .. } | Work::Write { .. } | Work::Read { .. }, .. }
        )
    }
}

impl I2c {
    /// When the present byte ends.
    pub fn next_event(&self) -> Ticks {
        match self.phase {
            Phase::Busy { until, .. } => until,
            Phase::Idle | Phase::Waiting { .. } => Ticks::NEVER,
        }
    }

    /// Does everything due up to `now`.
    pub fn advance(&mut self, now: Ticks) {
        while let Phase::Busy { work, until, .. } = self.phase {
            if until > now {
                return;
            }
            self.finish(work, until);
        }
    }

    /// Begins or resumes what the FIFO and the lines allow.
    pub(super) fn go_on(&mut self, now: Ticks) {
        match self.phase {
            Phase::Idle if self.is_enabled() && self.lines_free => {
                if let Some(first) = self.commands.front() {
                    let read = first.read;
                    self.latched |= ACTIVITY | START_DET;
                    self.begin(Work::Address { read }, ADDRESS_BITS, now);
                }
            }
            Phase::Waiting { read } => self.next(read, now),
            Phase::Idle | Phase::Busy { .. } => {}
        }
    }

    fn begin(&mut self, work: Work, bits: u64, from: Ticks) {
        self.phase = Phase::Busy { work, from, until: from + self.bits(bits) };
    }

    fn finish(&mut self, work: Work, at: Ticks) {
        // Whoever holds SDA overwrites the first 1 that this end sends.
        if work != Work::Stop && self.wires.holds_sda() {
            self.abort(ARB_LOST);
            self.wires.abandon();
            self.phase = Phase::Idle;
            return;
        }
        match work {
            Work::Address { read } => {
                if self.wires.start(at, (self.target & 0x7f) as u8, read) {
                    self.next_byte(at);
                } else {
                    self.abort(ABRT_7B_ADDR_NOACK);
                    self.begin(Work::Stop, 1, at);
                }
            }
            Work::Write { byte, stop } => {
                if self.wires.write(at, byte) {
                    self.after_byte(false, stop, at);
                } else {
                    self.abort(ABRT_TXDATA_NOACK);
                    self.begin(Work::Stop, 1, at);
                }
            }
            Work::Read { byte, stop } => {
                if self.received.len() < FIFO_DEPTH {
                    self.received.push_back(byte);
                } else {
                    self.latched |= RX_OVER;
                }
                self.after_byte(true, stop, at);
            }
            Work::Stop => {
                self.wires.stop(at);
                self.latched |= STOP_DET;
                self.phase = Phase::Idle;
                self.go_on(at);
            }
        }
    }

    fn after_byte(&mut self, read: bool, stop: bool, at: Ticks) {
        if stop {
            self.begin(Work::Stop, 1, at);
        } else {
            self.next(read, at);
        }
    }

    /// What follows a byte that was read or written, without a STOP.
    fn next(&mut self, read: bool, at: Ticks) {
        if !self.is_enabled() || self.abort_source != 0 {
            self.begin(Work::Stop, 1, at);
            return;
        }
        match self.commands.front() {
            None => self.phase = Phase::Waiting { read },
            Some(command) if command.read != read || command.restart => {
                let read = command.read;
                if self.control & RESTART_EN != 0 {
                    self.latched |= RESTART_DET;
                    self.begin(Work::Address { read }, ADDRESS_BITS, at);
                } else {
                    self.begin(Work::Stop, 1, at);
                }
            }
            Some(_) => self.next_byte(at),
        }
    }

    fn next_byte(&mut self, at: Ticks) {
        match self.commands.pop_front() {
            Some(command) if command.read => {
                let byte = self.wires.read(at);
                self.begin(Work::Read { byte, stop: command.stop }, BYTE_BITS, at);
            }
            Some(command) => {
                self.begin(Work::Write { byte: command.byte, stop: command.stop }, BYTE_BITS, at);
            }
            // The block was switched off meanwhile.
            None => self.begin(Work::Stop, 1, at),
        }
    }

    /// The transfer cannot go on: the FIFO is emptied and stays so until the program clears the
    /// abort.
    pub(super) fn abort(&mut self, source: u32) {
        let flushed = self.commands.len() as u32;
        self.abort_source |= source | flushed << 23;
        self.commands.clear();
        self.latched |= TX_ABRT;
    }

    /// The block stops in the middle of what it does. A part that was sending a 0 holds SDA until
    /// the clock takes it to the next 1 or past the acknowledgement.
    pub(super) fn cut(&mut self, now: Ticks) {
        if let Phase::Busy { work: Work::Read { byte, .. }, from, .. } = self.phase {
            let bit = self.bits(1).get().max(1);
            let sent = (now.saturating_sub(from).get() / bit).min(8) as u32;
            // The bits still to come, the present one first; behind them SDA is free.
            let zeros = if sent < 8 { (byte << sent).leading_zeros().min(8 - sent) } else { 0 };
            self.wires.hold_sda(zeros);
        }
        self.wires.abandon();
        self.phase = Phase::Idle;
    }
}
