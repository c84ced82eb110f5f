//! An RP2040 in virtual time.
//!
//! [`Chip`] loads a program's ELF file unchanged and runs it instruction by instruction. Nothing
//! here reads a clock: [`Chip::run_until`] takes the time to run to in [`Ticks`] of 8 ns, and
//! between two calls the caller moves bytes, levels and voltages in and out through the methods of
//! [`Chip`].
//!
//! # What is modelled
//!
//! - The Cortex-M0+ core 0: all of ARMv6-M, NVIC with priorities and preemption, SysTick,
//!   WFE/WFI/SEV, HardFault and lockup, the cycle counts of ARM's technical reference manual and
//!   the wait states of the APB bridge.
//! - UART0 and UART1 with FIFOs, interrupts, DMA requests, error bits and exact character times;
//!   DMA with chaining, rings, all four alias blocks and pacing; ADC with round robin and FIFO; PWM
//!   with double-buffered real counters; TIMER; WATCHDOG; SIO with spinlocks and divider; IO_BANK0
//!   with overrides and pin interrupts; PADS_BANK0 with pulls; RESETS; the clock tree from the
//!   oscillators to every consumer.
//! - I2C0 and I2C1 as controllers with 7-bit addresses: FIFOs, interrupts, aborts, times of bytes;
//!   on their buses emulated [`parts`], which can be put on, taken off and made to hold SDA low.
//! - As storage with the ready bits software waits for: XOSC (with its start-up delay), ROSC (with
//!   its divider), both PLLs, VREG, PSM; SPI without a bus behind it, SYSINFO, SYSCFG, TBMAN.
//! - Flash behind the XIP cache (16 KiB, two ways, lines of two words that are filled one by one)
//!   with its registers and counters; the SSI as far as boot loaders set it up. A miss takes as
//!   many serial clocks as the SSI's registers say, times its divider, and 10 processor cycles: 50
//!   cycles, or 400 ns at 125 MHz, after the boot loader for the W25Q080 family.
//! - Time is exact: every counter is computed from an exact fraction of its clock, whatever clocks
//!   the firmware sets.
//!
//! # What is not
//!
//! - **Boot ROM.** The core starts where the ROM hands over: in the second-stage boot loader, which
//!   it has copied to SRAM, or from the vector table at 0x1000_0100 if the boot block is blank; at
//!   6.5 MHz from the ring oscillator. On the board the ROM adds some milliseconds before it. There
//!   is no ROM image: its functions that change flash do so, with typical times of a W25Q16JV, and
//!   a power cut leaves the change half done; calls of the others (fast floating point) fault.
//!   Reads beyond the table of functions give zero and are reported.
//! - **Flash programming** through the SSI, and other flash chips than those that boot loaders for
//!   the W25Q080 family start; XIP streams, the cache as SRAM. Which way of the cache a miss
//!   replaces is not documented; here it is the one used less recently.
//! - **Bus contention** between the core and the DMA, and the DMA's own latency beyond one transfer
//!   a cycle.
//! - **Core 1**, USB, PIO, RTC, the interpolators, the DMA sniffer, the MPU, unprivileged mode,
//!   NMI, debug, sleep and dormant modes (power, not behaviour), the striping of SRAM and the
//!   aliases of its banks.
//! - I2C as a target, with other controllers, with 10-bit addresses or DMA; its levels within a
//!   transfer, and clock stretching by parts.
//! - UART flow control, loopback and IrDA; PWM inputs; the reception of bytes at a wrong baud rate;
//!   sub-bit jitter of the start bit; analogue effects of the ADC; tail-chaining (a handler that
//!   follows another directly starts some ten cycles late).
//! - Before a peripheral's reset has been released its registers are not there, as on the chip.
//!
//! Whatever the firmware touches of the second list is in [`Chip::unmodelled_accesses`]: a test
//! that trusts the emulation asserts that this list is empty.
//!
//! # Navigating
//!
//! `cortex_m0/` is the core, one file per encoding class of the architecture manual; `peripherals/`
//! one file per peripheral of the datasheet; `bus/` joins them: address map, events, DMA transfers,
//! clocks, pins. `chip.rs` runs it, `wires.rs` is the outside of the package, `debugger.rs` a probe
//! at it, `upsets.rs` what can be made to go wrong inside.

/// The README's example compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod bus;
mod chip;
mod cortex_m0;
mod debugger;
mod image;
pub mod parts;
mod peripherals;
mod report;
mod rtt;
mod ticks;
mod upsets;
mod wires;

pub use bus::{Edge, Level};
pub use chip::Chip;
pub use debugger::SEMIHOSTING;
pub use image::ElfError;
pub use peripherals::adc::Conversions;
pub use peripherals::uart::{LineErrors, Transmitted};
pub use report::{Access, Concern, Fault, FlashAccesses, HardFault, Reset, ResetReason, UnmodelledAccess};
pub use ticks::Ticks;
pub use wires::PINS;
