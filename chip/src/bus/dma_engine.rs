//! The DMA's bus side: which requests are up, and the transfers, one a clk_sys cycle.

use super::Bus;
use crate::peripherals::clocks::Hertz;
use crate::peripherals::dma::{Channel, Transfer, TransferError};
use crate::report::Fault;
use crate::ticks::{Rate, Ticks};

/// DREQ numbers (2.5.3.1).
mod request {
    pub const UART0_TX: u32 = 20;
    pub const UART0_RX: u32 = 21;
    pub const UART1_TX: u32 = 22;
    pub const UART1_RX: u32 = 23;
    pub const PWM_WRAP0: u32 = 24;
    pub const ADC: u32 = 36;
    pub const PERMANENT: u32 = 0x3f;
}

/// When the engine can make its next transfer.
#[derive(Clone, Debug, Default)]
pub(super) struct DmaEngine {
    free_at: Ticks,
    cycle: Ticks,
    transfers: u64,
}

impl DmaEngine {
    pub fn set_clock(&mut self, (numerator, denominator): Hertz) {
        let rate = Rate::hertz(numerator, denominator);
        if !rate.is_stopped() {
            self.cycle = rate.ticks_for(1);
        }
    }
}

impl Bus {
    /// Level requests. Pulses (PWM, timers) arrive as credits of the channels. The chip counts
    /// credits for UART and ADC too (2.5.3.2), which is the same as long as nobody else touches a
    /// FIFO that the DMA serves.
    fn dma_requested(&self, channel: &Channel) -> bool {
        match channel.request() {
            request::PERMANENT => true,
            request::UART0_TX => self.uarts[0].transmit_request(),
            request::UART0_RX => self.uarts[0].receive_request(),
            request::UART1_TX => self.uarts[1].transmit_request(),
            request::UART1_RX => self.uarts[1].receive_request(),
            request::ADC => self.adc.request(),
            _ => false,
        }
    }

    /// PWM wraps since the last look become credits; slices that pace a channel make their wraps
    /// events.
    pub(super) fn pace_dma_by_pwm(&mut self) {
        let wraps = self.pwm.take_wraps();
        for slice in (0..8).filter(|slice| wraps >> slice & 1 != 0) {
            self.dma.pulse(request::PWM_WRAP0 + slice);
        }
        self.pwm.set_pacing(self.dma.paced_by_pwm(), self.now);
    }

    fn ready_channel(&self) -> Option<usize> {
        if self.dma.any_busy() { self.dma.choose(|channel| self.dma_requested(channel)) } else { None }
    }

    /// A channel loses what it was doing.
    pub fn abort_dma(&mut self, channel: usize) {
        self.dma.abort(channel, self.now);
        self.settle();
    }

    /// When the engine next moves something; never without a request.
    pub(super) fn next_dma_transfer(&self) -> Ticks {
        if self.ready_channel().is_some() { self.dma_engine.free_at } else { Ticks::NEVER }
    }

    /// Makes the transfers possible at `at`: one, if the engine is free.
    pub(super) fn run_dma(&mut self, at: Ticks) {
        if self.dma_engine.free_at > at {
            return;
        }
        let Some(number) = self.ready_channel() else { return };
        self.dma_engine.free_at = at + self.dma_engine.cycle;
        self.dma_engine.transfers += 1;
        let transfer = self.dma.channels[number].transfer();
        let wait = self.take_wait_cycles();
        let result = self.move_data(transfer);
        // It is not the processor that waits for what the DMA reads from flash.
        self.set_wait_cycles(wait);
        self.dma.complete(number, result, at);
    }

    fn move_data(&mut self, transfer: Transfer) -> Result<(), TransferError> {
        let Transfer { from, to, size, swap } = transfer;
        let value = self.dma_read(from, size).map_err(|_| TransferError::Read)?;
        let value = match (swap, size) {
            (true, 2) => u32::from((value as u16).swap_bytes()),
            (true, 4) => value.swap_bytes(),
            _ => value,
        };
        self.dma_write(to, value, size).map_err(|_| TransferError::Write)
    }

    fn dma_read(&mut self, address: u32, size: u32) -> Result<u32, Fault> {
        if is_register(address) {
            aligned(address, size)?;
            return Ok(self.read_register_quietly(address & !3) >> (8 * (address & 3)));
        }
        memory_only(address)?;
        match size {
            1 => self.read8(address).map(u32::from),
            2 => self.read16(address).map(u32::from),
            _ => self.read32(address),
        }
    }

    fn dma_write(&mut self, address: u32, value: u32, size: u32) -> Result<(), Fault> {
        if is_register(address) {
            aligned(address, size)?;
            let lanes = match size {
                1 => (value & 0xff) * 0x0101_0101,
                2 => (value & 0xffff) * 0x0001_0001,
                _ => value,
            };
            self.write_register_quietly(address & !3, lanes);
            return Ok(());
        }
        memory_only(address)?;
        match size {
            1 => self.write8(address, value as u8),
            2 => self.write16(address, value as u16),
            _ => self.write32(address, value),
        }
    }
}

fn is_register(address: u32) -> bool {
    (0x4000_0000..0x6000_0000).contains(&address)
}

fn aligned(address: u32, size: u32) -> Result<(), Fault> {
    if address.is_multiple_of(size) { Ok(()) } else { Err(Fault::Unaligned(address)) }
}

/// The DMA does not reach the core's own SIO.
fn memory_only(address: u32) -> Result<(), Fault> {
    if address >> 28 == 0xd { Err(Fault::Bus(address)) } else { Ok(()) }
}
