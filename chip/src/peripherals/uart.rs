//! UART0 and UART1 (4.2): ARM PL011 (ARM DDI 0183) with 32-byte FIFOs and its time base in
//! fractions of a bit.

mod receive;
mod transmit;

#[cfg(test)]
mod tests;

use super::{RegisterWrite, Written};
use crate::ticks::{Rate, Ticks};

pub use receive::LineErrors;
pub use transmit::Transmitted;

use receive::Receiver;
use transmit::Transmitter;

/// Register offsets (4.2.8).
pub(crate) const UARTDR: u32 = 0x000;
const UARTRSR: u32 = 0x004;
const UARTFR: u32 = 0x018;
const UARTILPR: u32 = 0x020;
const UARTIBRD: u32 = 0x024;
const UARTFBRD: u32 = 0x028;
const UARTLCR_H: u32 = 0x02c;
const UARTCR: u32 = 0x030;
const UARTIFLS: u32 = 0x034;
const UARTIMSC: u32 = 0x038;
const UARTRIS: u32 = 0x03c;
const UARTMIS: u32 = 0x040;
const UARTICR: u32 = 0x044;
const UARTDMACR: u32 = 0x048;
const UARTPERIPHID0: u32 = 0xfe0;
const UARTPCELLID3: u32 = 0xffc;

/// UARTRIS, UARTIMSC, UARTMIS, UARTICR.
const RX_INTERRUPT: u32 = 1 << 4;
const TX_INTERRUPT: u32 = 1 << 5;
const RECEIVE_TIMEOUT: u32 = 1 << 6;
const FRAMING_ERROR: u32 = 1 << 7;
const PARITY_ERROR: u32 = 1 << 8;
const BREAK_ERROR: u32 = 1 << 9;
const OVERRUN_ERROR: u32 = 1 << 10;
const ERROR_INTERRUPTS: u32 = FRAMING_ERROR | PARITY_ERROR | BREAK_ERROR | OVERRUN_ERROR;
const ALL_INTERRUPTS: u32 = 0x7ff;

/// UARTCR.
const UARTEN: u32 = 1 << 0;
const SIREN: u32 = 1 << 1;
const LBE: u32 = 1 << 7;
const TXE: u32 = 1 << 8;
const RXE: u32 = 1 << 9;
const RTSEN: u32 = 1 << 14;
const CTSEN: u32 = 1 << 15;

/// UARTLCR_H.
const BRK: u32 = 1 << 0;
const PEN: u32 = 1 << 1;
const STP2: u32 = 1 << 3;
const FEN: u32 = 1 << 4;

/// UARTDMACR.
const RXDMAE: u32 = 1 << 0;
const TXDMAE: u32 = 1 << 1;
const DMAONERR: u32 = 1 << 2;

const FIFO_DEPTH: usize = 32;

/// One UART.
#[derive(Clone, Debug)]
pub(crate) struct Uart {
    integer_divisor: u32,
    fractional_divisor: u32,
    line_control: u32,
    control: u32,
    fifo_levels: u32,
    mask: u32,
    raw: u32,
    dma_control: u32,
    low_power: u32,
    /// Sixteenths of a bit in 64ths of a clk_peri cycle: the divisors as they were when UARTLCR_H
    /// was last written, which is what makes them take effect.
    divisor: u64,
    /// 64ths of clk_peri cycles per tick.
    clock: Rate,
    transmitter: Transmitter,
    receiver: Receiver,
}

impl Default for Uart {
    fn default() -> Self {
        Uart {
            integer_divisor: 0,
            fractional_divisor: 0,
            line_control: 0,
            control: TXE | RXE,
            fifo_levels: 0x12,
            mask: 0,
            raw: 0,
            dma_control: 0,
            low_power: 0,
            divisor: 0,
            clock: Rate::STOPPED,
            transmitter: Transmitter::default(),
            receiver: Receiver::default(),
        }
    }
}

impl Uart {
    /// The UART after a reset: registers and FIFOs are gone, what is on the wire stays.
    pub fn reset(&mut self) {
        let mut fresh = Uart { clock: self.clock, ..Uart::default() };
        fresh.receiver.take_wire(&mut self.receiver);
        fresh.transmitter.take_wire(&mut self.transmitter);
        *self = fresh;
    }

    /// clk_peri is now `numerator / denominator` hertz.
    pub fn set_clock(&mut self, (numerator, denominator): (u64, u64)) {
        self.clock = Rate::hertz(64 * numerator, denominator);
    }

    /// Duration of `bits` bits in 64ths of a clk_peri cycle.
    fn bits(&self, bits: u64) -> u64 {
        16 * self.divisor * bits
    }

    /// Bits per second, to the nearest.
    pub fn baud(&self) -> u64 {
        let counts = self.bits(1).max(1);
        let second = self.clock.counts_in(Ticks::new(Ticks::PER_SECOND));
        if self.divisor == 0 { 0 } else { (second + counts / 2) / counts }
    }

    /// Bits of a character on the wire: start, data, parity, stop.
    fn character_bits(&self) -> u64 {
        let data = 5 + u64::from(self.line_control >> 5 & 3);
        let parity = u64::from(self.line_control & PEN != 0);
        let stop = 1 + u64::from(self.line_control & STP2 != 0);
        1 + data + parity + stop
    }

    /// Bits of the data word.
    fn data_mask(&self) -> u8 {
        0xff >> (3 - (self.line_control >> 5 & 3))
    }

    fn fifo_depth(&self) -> usize {
        if self.line_control & FEN != 0 { FIFO_DEPTH } else { 1 }
    }

    /// Bytes at which an interrupt level is reached (UARTIFLS).
    fn level(select: u32) -> usize {
        match select & 7 {
            0 => 4,
            1 => 8,
            2 => 16,
            3 => 24,
            _ => 28,
        }
    }

    fn enabled(&self, direction: u32) -> bool {
        self.control & (UARTEN | direction) == UARTEN | direction
    }

    pub fn read(&mut self, offset: u32) -> Option<u32> {
        Some(match offset {
            UARTDR => self.read_data(),
            UARTRSR => self.receiver.status,
            UARTFR => self.flags(),
            UARTILPR => self.low_power,
            UARTIBRD => self.integer_divisor,
            UARTFBRD => self.fractional_divisor,
            UARTLCR_H => self.line_control,
            UARTCR => self.control,
            UARTIFLS => self.fifo_levels,
            UARTIMSC => self.mask,
            UARTRIS => self.raw,
            UARTMIS => self.raw & self.mask,
            UARTDMACR => self.dma_control,
            UARTICR => 0,
            UARTPERIPHID0..=UARTPCELLID3 => {
                const IDENTIFICATION: [u32; 8] = [0x11, 0x10, 0x34, 0x00, 0x0d, 0xf0, 0x05, 0xb1];
                IDENTIFICATION[((offset - UARTPERIPHID0) / 4) as usize]
            }
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, write: RegisterWrite, now: Ticks) -> Written {
        match offset {
            UARTDR => self.write_data(write.raw as u8, now),
            UARTRSR => self.receiver.status = 0,
            UARTILPR => self.low_power = write.onto(self.low_power) & 0xff,
            UARTIBRD => self.integer_divisor = write.onto(self.integer_divisor) & 0xffff,
            UARTFBRD => self.fractional_divisor = write.onto(self.fractional_divisor) & 0x3f,
            UARTLCR_H => {
                self.line_control = write.onto(self.line_control) & 0xff;
                self.divisor = u64::from(64 * self.integer_divisor + self.fractional_divisor);
                self.transmitter.set_break(self.line_control & BRK != 0);
                self.shrink_fifos();
            }
            UARTCR => {
                self.control = write.onto(self.control) & 0xff87;
                self.start_transmission(now);
                if self.control & (SIREN | RTSEN | CTSEN | LBE) != 0 {
                    return Written::ValueNotModelled;
                }
            }
            UARTIFLS => self.fifo_levels = write.onto(self.fifo_levels) & 0x3f,
            UARTIMSC => self.mask = write.onto(self.mask) & ALL_INTERRUPTS,
            UARTICR => self.raw &= !write.ones(),
            UARTDMACR => self.dma_control = write.onto(self.dma_control) & 7,
            UARTFR | UARTRIS | UARTMIS => {}
            _ => return Written::NotModelled,
        }
        Written::Done
    }

    /// UARTFR. The modem inputs are not connected.
    fn flags(&self) -> u32 {
        let depth = self.fifo_depth();
        let bit = |set: bool, n: u32| u32::from(set) << n;
        bit(self.transmitter.is_busy(), 3)
            | bit(self.receiver.queued() == 0, 4)
            | bit(self.transmitter.queued() >= depth, 5)
            | bit(self.receiver.queued() >= depth, 6)
            | bit(self.transmitter.queued() == 0, 7)
    }

    /// Switching the FIFOs off leaves room for one character in each direction.
    fn shrink_fifos(&mut self) {
        let depth = self.fifo_depth();
        self.transmitter.truncate(depth);
        self.receiver.truncate(depth);
    }

    /// When this UART next does something by itself.
    pub fn next_event(&self) -> Ticks {
        self.transmitter.next_event().min(self.receiver.next_event())
    }

    /// Does everything due up to `now`. `receive_pin`: some pin is switched to this UART's RX.
    pub fn advance(&mut self, now: Ticks, receive_pin: bool) {
        self.finish_transmission(now);
        self.receive_due(now, receive_pin);
    }

    /// The interrupt line.
    pub fn interrupt(&self) -> bool {
        self.raw & self.mask != 0
    }

    /// DMA request to write to UARTDR: there is room.
    pub fn transmit_request(&self) -> bool {
        self.dma_control & TXDMAE != 0
            && self.control & UARTEN != 0
            && self.transmitter.queued() < self.fifo_depth()
    }

    /// DMA request to read from UARTDR: there is a character, and no error interrupt stops it
    /// (DMAONERR).
    pub fn receive_request(&self) -> bool {
        let stopped = self.dma_control & DMAONERR != 0 && self.raw & self.mask & ERROR_INTERRUPTS != 0;
        self.dma_control & RXDMAE != 0 && self.receiver.queued() > 0 && !stopped
    }
}
