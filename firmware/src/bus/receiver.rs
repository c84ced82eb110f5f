//! Two DMA channels that take turns for ever: one carries a character from the UART, the next the
//! time from the timer.
//!
//! ```text
//!  UART0 DR --(channel 0, when there is a character)--> CHARACTERS[n]
//!                                                            | chains to
//!  TIMERAWL --(channel 1, at once)--------------------> STAMPS[n]
//!                                                            | n = n + 1 mod 64, interrupt,
//!                                                            | chains to channel 0
//! ```
//!
//! So every byte has the time at which it came, to the microsecond, however late the interrupt is:
//! gaps between frames are found from these times. Nothing is lost as long as the interrupt comes
//! within 64 characters (640 us at 1 Mbaud). RP2040 datasheet 2.5 (DMA: chaining 2.5.2.2 and rings
//! 2.5.2.4), 4.2 (UART), 4.6 (timer).

use crate::chip::{self, TIMER};
use core::cell::UnsafeCell;
use embassy_rp::Peri;
use embassy_rp::pac::{DMA, UART0, dma};
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1};

const CHARACTERS_CHANNEL: usize = 0;
const STAMPS_CHANNEL: usize = 1;
/// Which of the DMA's two interrupt lines; Embassy uses line 0.
const INTERRUPT_LINE: usize = 1;

const RING_LEN: usize = 64;

/// A ring that a DMA channel writes. Aligned to at least its size, as the channel's address wrap
/// needs.
#[repr(C, align(256))]
struct Ring<T>(UnsafeCell<[T; RING_LEN]>);

// SAFETY: written by the DMA only, and read (volatile) only where it has already written, by the
// one `Receiver`.
unsafe impl<T: Send> Sync for Ring<T> {}

static CHARACTERS: Ring<u16> = Ring(UnsafeCell::new([0; RING_LEN]));
static STAMPS: Ring<u32> = Ring(UnsafeCell::new([0; RING_LEN]));

impl<T: Copy> Ring<T> {
    const SIZE_BITS: u8 = size_of::<[T; RING_LEN]>().trailing_zeros() as u8;

    fn address(&self) -> u32 {
        self.0.get() as u32
    }

    fn read(&self, index: usize) -> T {
        let element = self.0.get().cast::<T>().wrapping_add(index % RING_LEN);
        // SAFETY: the index is within the array, and the DMA writes whole elements.
        unsafe { element.read_volatile() }
    }
}

/// A character from the UART.
pub struct Character {
    /// What the data register held: the byte, and four error flags above it (4.2.8, UARTDR).
    data: u16,
    /// Low word of the time at which its stop bit had been seen, us.
    pub stamp: u32,
}

/// Framing error, parity error, break, or characters lost before this one.
pub struct Damaged;

impl Character {
    /// The byte, unless the UART flagged it.
    pub fn byte(&self) -> Result<u8, Damaged> {
        let [flags, byte] = self.data.to_be_bytes();
        if flags == 0 { Ok(byte) } else { Err(Damaged) }
    }
}

/// Reads what the two channels have written.
pub struct Receiver {
    next: usize,
}

impl Receiver {
    /// Sets both channels going. The UART must have been set up.
    pub fn start(_characters: Peri<'static, DMA_CH0>, _stamps: Peri<'static, DMA_CH1>) -> Self {
        let channel = DMA.ch(STAMPS_CHANNEL);
        channel.read_addr().write_value(TIMER.timerawl().as_ptr() as u32);
        channel.write_addr().write_value(STAMPS.address());
        chip::set_transfer_count(channel, 1);
        let mut control = dma::regs::CtrlTrig(0);
        control.set_treq_sel(dma::vals::TreqSel::PERMANENT);
        control.set_data_size(dma::vals::DataSize::SIZE_WORD);
        control.set_incr_write(true);
        control.set_ring_sel(true);
        control.set_ring_size(Ring::<u32>::SIZE_BITS);
        control.set_chain_to(CHARACTERS_CHANNEL as u8);
        control.set_en(true);
        // The alias does not start the channel.
        channel.al1_ctrl().write_value(control.0);
        DMA.inte(INTERRUPT_LINE).write_value(1 << STAMPS_CHANNEL);

        let channel = DMA.ch(CHARACTERS_CHANNEL);
        channel.read_addr().write_value(UART0.uartdr().as_ptr() as u32);
        channel.write_addr().write_value(CHARACTERS.address());
        chip::set_transfer_count(channel, 1);
        control.set_treq_sel(dma::vals::TreqSel::UART0_RX);
        control.set_data_size(dma::vals::DataSize::SIZE_HALFWORD);
        control.set_ring_size(Ring::<u16>::SIZE_BITS);
        control.set_chain_to(STAMPS_CHANNEL as u8);
        control.set_irq_quiet(true);
        channel.ctrl_trig().write_value(control);
        UART0.uartdmacr().modify(|w| w.set_rxdmae(true));

        Self { next: 0 }
    }

    /// The next character heard, if there is one.
    pub fn next(&mut self) -> Option<Character> {
        // The stamp is written last: up to here both rings are filled.
        let written =
            (DMA.ch(STAMPS_CHANNEL).write_addr().read() - STAMPS.address()) as usize / size_of::<u32>();
        if self.next == written {
            return None;
        }
        let character = Character { data: CHARACTERS.read(self.next), stamp: STAMPS.read(self.next) };
        self.next = (self.next + 1) % RING_LEN;
        Some(character)
    }

    /// Whether a channel waits for the next character.
    pub fn is_listening(&self) -> bool {
        DMA.ch(CHARACTERS_CHANNEL).ctrl_trig().read().busy()
    }
}

/// Takes back the interrupt request. Before looking for characters, so that none that comes
/// meanwhile is missed.
pub fn acknowledge() {
    DMA.ints(INTERRUPT_LINE).write_value(1 << STAMPS_CHANNEL);
}
