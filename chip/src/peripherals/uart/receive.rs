//! Receive FIFO, error bits and the receive timeout.

use std::collections::VecDeque;

use super::{
    BREAK_ERROR, FRAMING_ERROR, OVERRUN_ERROR, PARITY_ERROR, RECEIVE_TIMEOUT, RX_INTERRUPT, RXE, Uart,
};
use crate::ticks::Ticks;

/// What was wrong with a character on the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineErrors {
    /// The stop bit was low.
    pub framing: bool,
    /// The parity bit was wrong.
    pub parity: bool,
    /// The line was low for the whole character.
    pub line_break: bool,
}

impl LineErrors {
    /// A good character.
    pub const NONE: LineErrors = LineErrors { framing: false, parity: false, line_break: false };

    /// UARTDR bits 10 to 8: BE, PE, FE. A break is a framing error too.
    fn data_bits(self) -> u32 {
        u32::from(self.framing || self.line_break) << 8
            | u32::from(self.parity) << 9
            | u32::from(self.line_break) << 10
    }

    fn interrupts(self) -> u32 {
        let when = |condition: bool, interrupt: u32| if condition { interrupt } else { 0 };
        when(self.framing || self.line_break, FRAMING_ERROR)
            | when(self.parity, PARITY_ERROR)
            | when(self.line_break, BREAK_ERROR)
    }
}

/// UARTDR and UARTRSR: overrun.
const OVERRUN_BIT: u32 = 1 << 11;
/// Bits of silence after which the receive timeout is raised.
const TIMEOUT_BITS: u64 = 32;

/// A character on its way into the UART.
#[derive(Clone, Copy, Debug)]
struct Incoming {
    stop_bit_at: Ticks,
    byte: u8,
    errors: LineErrors,
}

#[derive(Clone, Debug)]
pub(super) struct Receiver {
    /// Entries of UARTDR.
    fifo: VecDeque<u32>,
    /// UARTRSR.
    pub status: u32,
    wire: VecDeque<Incoming>,
    timeout_at: Ticks,
    /// A character was lost; the next one that fits carries the overrun bit.
    overrun: bool,
    /// Characters lost to a full FIFO.
    overruns: u64,
}

impl Default for Receiver {
    fn default() -> Self {
        Receiver {
            fifo: VecDeque::new(),
            status: 0,
            wire: VecDeque::new(),
            timeout_at: Ticks::NEVER,
            overrun: false,
            overruns: 0,
        }
    }
}

impl Receiver {
    pub fn queued(&self) -> usize {
        self.fifo.len()
    }

    pub fn truncate(&mut self, depth: usize) {
        self.fifo.truncate(depth);
    }

    pub fn next_event(&self) -> Ticks {
        self.wire.front().map_or(Ticks::NEVER, |incoming| incoming.stop_bit_at).min(self.timeout_at)
    }

    /// Keeps what is on the wire, and the count of lost characters, across a reset.
    pub fn take_wire(&mut self, before: &mut Receiver) {
        self.wire = std::mem::take(&mut before.wire);
        self.overruns = before.overruns;
    }
}

impl Uart {
    /// Puts a character on the line into this UART, in order of time; see
    /// [`crate::Chip::uart_receive`].
    pub fn put_on_wire(&mut self, stop_bit_at: Ticks, byte: u8, errors: LineErrors) {
        let wire = &mut self.receiver.wire;
        let position = wire.partition_point(|incoming| incoming.stop_bit_at <= stop_bit_at);
        wire.insert(position, Incoming { stop_bit_at, byte, errors });
    }

    /// Characters lost because the FIFO was full.
    pub fn overruns(&self) -> u64 {
        self.receiver.overruns
    }

    pub(super) fn read_data(&mut self) -> u32 {
        let entry = self.receiver.fifo.pop_front().unwrap_or(0);
        self.receiver.status = entry >> 8;
        if self.receiver.fifo.len() < self.receive_level() {
            self.raw &= !RX_INTERRUPT;
        }
        if self.receiver.fifo.is_empty() {
            self.raw &= !RECEIVE_TIMEOUT;
            self.receiver.timeout_at = Ticks::NEVER;
        }
        entry
    }

    /// FIFO length at which the receive interrupt is raised.
    fn receive_level(&self) -> usize {
        if self.fifo_depth() == 1 { 1 } else { Uart::level(self.fifo_levels >> 3) }
    }

    /// Takes in the characters whose stop bit has come, and raises the timeout.
    pub(super) fn receive_due(&mut self, now: Ticks, receive_pin: bool) {
        while let Some(incoming) = self.receiver.wire.front().copied().filter(|i| i.stop_bit_at <= now) {
            self.receiver.wire.pop_front();
            self.raise_timeout(incoming.stop_bit_at);
            if receive_pin && self.enabled(RXE) {
                self.receive(incoming);
            }
        }
        self.raise_timeout(now);
    }

    fn raise_timeout(&mut self, now: Ticks) {
        if self.receiver.timeout_at <= now {
            self.receiver.timeout_at = Ticks::NEVER;
            self.raw |= RECEIVE_TIMEOUT;
        }
    }

    fn receive(&mut self, incoming: Incoming) {
        if self.receiver.fifo.len() >= self.fifo_depth() {
            self.receiver.overrun = true;
            self.receiver.overruns += 1;
            self.receiver.status |= OVERRUN_BIT >> 8;
            self.raw |= OVERRUN_ERROR;
            return;
        }
        let overrun = if std::mem::take(&mut self.receiver.overrun) { OVERRUN_BIT } else { 0 };
        let byte = if incoming.errors.line_break { 0 } else { incoming.byte & self.data_mask() };
        self.receiver.fifo.push_back(u32::from(byte) | incoming.errors.data_bits() | overrun);
        self.raw |= incoming.errors.interrupts();
        if self.receiver.fifo.len() >= self.receive_level() {
            self.raw |= RX_INTERRUPT;
        }
        self.receiver.timeout_at = incoming.stop_bit_at + self.clock.ticks_for(self.bits(TIMEOUT_BITS));
    }
}
