//! Transmit FIFO and shift register.

use std::collections::VecDeque;

use super::{TX_INTERRUPT, TXE, Uart};
use crate::ticks::Ticks;

/// A character the UART has begun to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transmitted {
    /// Beginning of the start bit.
    pub start: Ticks,
    /// End of the last stop bit.
    pub end: Ticks,
    /// The character; words shorter than eight bits are in the low bits.
    pub byte: u8,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Transmitter {
    fifo: VecDeque<u8>,
    shifting: Option<Transmitted>,
    /// Start of the present uninterrupted run of characters and its length so far in 64ths of a
    /// clk_peri cycle: ends are computed from here, so that rounding to ticks does not add up.
    run_start: Ticks,
    run_length: u64,
    sending_break: bool,
    /// Some pin is switched to this UART's TX.
    pub on_a_pin: bool,
    sent: VecDeque<Transmitted>,
}

impl Transmitter {
    pub fn queued(&self) -> usize {
        self.fifo.len()
    }

    /// UARTFR.BUSY: until the last stop bit has been sent.
    pub fn is_busy(&self) -> bool {
        self.shifting.is_some() || !self.fifo.is_empty()
    }

    pub fn truncate(&mut self, depth: usize) {
        self.fifo.truncate(depth);
    }

    pub fn set_break(&mut self, on: bool) {
        self.sending_break = on;
    }

    pub fn next_event(&self) -> Ticks {
        self.shifting.map_or(Ticks::NEVER, |character| character.end)
    }

    /// Keeps what is already on the wire across a reset.
    pub fn take_wire(&mut self, before: &mut Transmitter) {
        self.sent = std::mem::take(&mut before.sent);
    }
}

impl Uart {
    pub(super) fn write_data(&mut self, byte: u8, now: Ticks) {
        if self.transmitter.fifo.len() < self.fifo_depth() {
            self.transmitter.fifo.push_back(byte & self.data_mask());
        }
        self.start_transmission(now);
        if self.transmitter.fifo.len() > self.transmit_level() {
            self.raw &= !TX_INTERRUPT;
        }
    }

    /// FIFO length at which the transmit interrupt is raised on the way down.
    fn transmit_level(&self) -> usize {
        if self.fifo_depth() == 1 { 0 } else { Uart::level(self.transmit_level_select()) }
    }

    /// UARTIFLS.TXIFLSEL counts free space: 0 means an eighth full.
    fn transmit_level_select(&self) -> u32 {
        self.fifo_levels & 7
    }

    /// Moves the next character into an idle shift register. The start bit goes out at once; on the
    /// chip it waits for the next sixteenth of a bit.
    pub(super) fn start_transmission(&mut self, now: Ticks) {
        if self.transmitter.shifting.is_some()
            || !self.enabled(TXE)
            || self.divisor == 0
            || self.clock.is_stopped()
        {
            return;
        }
        let Some(byte) = self.transmitter.fifo.pop_front() else { return };
        let level = self.transmit_level();
        let character_length = self.bits(self.character_bits());
        let transmitter = &mut self.transmitter;
        if transmitter.run_start + self.clock.ticks_for(transmitter.run_length) != now {
            transmitter.run_start = now;
            transmitter.run_length = 0;
        }
        transmitter.run_length += character_length;
        let end = transmitter.run_start + self.clock.ticks_for(transmitter.run_length);
        let character = Transmitted { start: now, end, byte };
        transmitter.shifting = Some(character);
        if transmitter.on_a_pin {
            transmitter.sent.push_back(character);
        }
        if transmitter.fifo.len() == level {
            self.raw |= TX_INTERRUPT;
        }
    }

    /// Ends the characters whose stop bit is over and starts the next ones without a gap.
    pub(super) fn finish_transmission(&mut self, now: Ticks) {
        while let Some(character) = self.transmitter.shifting.filter(|c| c.end <= now) {
            self.transmitter.shifting = None;
            self.start_transmission(character.end);
        }
    }

    /// Some pin is, or none is any more, switched to this UART's TX.
    pub fn set_transmit_pin(&mut self, connected: bool) {
        self.transmitter.on_a_pin = connected;
    }

    /// Takes what has been put on the wire since the last call, the character being sent included.
    pub fn take_transmitted(&mut self) -> impl Iterator<Item = Transmitted> + '_ {
        self.transmitter.sent.drain(..)
    }

    /// Level of the TX line at `now`: high when idle, low in a start bit or a break.
    pub fn transmit_line(&self, now: Ticks) -> bool {
        if self.transmitter.sending_break {
            return false;
        }
        let Some(character) = self.transmitter.shifting else { return true };
        let elapsed = self.clock.counts_in(now.saturating_sub(character.start));
        match elapsed / self.bits(1).max(1) {
            0 => false,
            bit => {
                let data_bits = u64::from(self.data_mask().count_ones());
                if bit <= data_bits {
                    character.byte >> (bit - 1) & 1 != 0
                } else {
                    self.parity_or_stop(character.byte, bit - data_bits)
                }
            }
        }
    }

    /// The `n`th bit after the data, from 1.
    fn parity_or_stop(&self, byte: u8, n: u64) -> bool {
        if self.line_control & super::PEN == 0 || n > 1 {
            return true;
        }
        const EPS: u32 = 1 << 2;
        const SPS: u32 = 1 << 7;
        let even = self.line_control & EPS != 0;
        if self.line_control & SPS != 0 {
            return !even;
        }
        let odd_ones = byte.count_ones() % 2 == 1;
        odd_ones == even
    }
}
