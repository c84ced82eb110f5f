//! The peripherals as they are wired: through addresses, interrupt lines and time.

mod clocks;
mod dma;
mod flash;
mod i2c;
mod memory;
mod pins;
mod registers;

use super::Bus;
use crate::ticks::Ticks;

const RESETS: u32 = 0x4000_c000;
const CLOCKS: u32 = 0x4000_8000;
const IO_BANK0: u32 = 0x4001_4000;
const PADS_BANK0: u32 = 0x4001_c000;
const XOSC: u32 = 0x4002_4000;
const PLL_SYS: u32 = 0x4002_8000;
const PLL_USB: u32 = 0x4002_c000;
const UART0: u32 = 0x4003_4000;
const ADC: u32 = 0x4004_c000;
const PWM: u32 = 0x4005_0000;
const TIMER: u32 = 0x4005_4000;
const WATCHDOG: u32 = 0x4005_8000;
const DMA: u32 = 0x5000_0000;
const SIO: u32 = 0xd000_0000;

/// FUNCSEL.
const FUNCTION_UART: u32 = 2;
const FUNCTION_PWM: u32 = 4;
const FUNCTION_SIO: u32 = 5;

/// A bus with everything out of reset.
fn bus() -> Bus {
    let mut bus = Bus::new((0..=255).collect::<Vec<u8>>().into());
    write(&mut bus, RESETS, 0);
    bus
}

/// The usual clocks: 12 MHz crystal, 125 MHz system and peripheral clock, 48 MHz ADC, 1 us tick.
fn clocked_bus() -> Bus {
    let mut bus = bus();
    for (pll, feedback, post) in [(PLL_SYS, 125, 6 << 16 | 2 << 12), (PLL_USB, 100, 5 << 16 | 5 << 12)] {
        write(&mut bus, pll + 0x8, feedback);
        write(&mut bus, pll + 0xc, post);
        write(&mut bus, pll + 0x4, 0);
    }
    write(&mut bus, CLOCKS + 0x30, 2);
    write(&mut bus, CLOCKS + 0x3c, 1);
    write(&mut bus, CLOCKS + 0x48, 1 << 11);
    write(&mut bus, CLOCKS + 0x60, 1 << 11);
    write(&mut bus, WATCHDOG + 0x2c, 1 << 9 | 12);
    bus
}

fn write(bus: &mut Bus, address: u32, value: u32) {
    bus.write32(address, value).expect("a writable address");
}

fn read(bus: &mut Bus, address: u32) -> u32 {
    bus.read32(address).expect("a readable address")
}

fn select_function(bus: &mut Bus, pin: u32, function: u32) {
    write(bus, IO_BANK0 + 8 * pin + 4, function);
}

/// Lets time pass, event by event.
fn run(bus: &mut Bus, until: Ticks) {
    while bus.next_event() <= until {
        bus.now = bus.now.max(bus.next_event());
        bus.advance();
    }
    bus.now = until;
}

/// The accesses reported so far, in words.
fn reports(bus: &Bus) -> Vec<String> {
    bus.unmodelled().iter().map(|(access, count)| format!("{access} x{count}")).collect()
}
