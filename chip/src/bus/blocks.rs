//! Which peripheral answers at which address (2.2): for each block what holds it in reset, and how
//! it is read and written.

use super::Bus;
use crate::peripherals::resets::bit;
use crate::peripherals::{RegisterWrite, Written, adc, uart};

/// Each block has 16 KiB, four times 4 KiB for the atomic aliases.
const BLOCK_BITS: u32 = 14;
/// The block on the AHB-Lite. All others are behind the APB bridge, from 0x4000_0000 on.
const DMA: u32 = 0x5000_0000 >> BLOCK_BITS;
const APB: u32 = 0x4000_0000 >> BLOCK_BITS;

/// A block of registers.
pub(super) struct Block {
    /// Its bit in RESETS, as a mask; 0 if nothing holds it in reset.
    pub held_by: u32,
    /// The register at an offset. Time has not been caught up with.
    pub read: fn(&mut Bus, u32) -> Option<u32>,
    /// Whether what `read` did can have changed interrupts or requests to DMA.
    pub read_takes: Takes,
    /// Writes the register at an offset.
    pub write: fn(&mut Bus, u32, RegisterWrite) -> Written,
}

/// Which reads take something away: a FIFO entry, or an interrupt.
#[derive(Clone, Copy)]
pub(super) enum Takes {
    Never,
    /// Of the register at this offset.
    At(u32),
    Always,
}

impl Takes {
    #[inline]
    pub fn takes(self, offset: u32) -> bool {
        match self {
            Takes::Never => false,
            Takes::At(taking) => offset == taking,
            Takes::Always => true,
        }
    }
}

/// The block that an address is in.
#[inline]
pub(super) fn block_at(address: u32) -> &'static Block {
    let number = address >> BLOCK_BITS;
    let apb = number.wrapping_sub(APB) as usize;
    if apb < APB_BLOCKS {
        &BEHIND_APB[apb]
    } else if number == DMA {
        &DMA_BLOCK
    } else {
        &NOTHING
    }
}

const fn block(
    held_by: u32,
    read: fn(&mut Bus, u32) -> Option<u32>,
    write: fn(&mut Bus, u32, RegisterWrite) -> Written,
) -> Block {
    Block { held_by, read, read_takes: Takes::Never, write }
}

const fn taking(read_takes: Takes, block: Block) -> Block {
    Block { read_takes, ..block }
}

/// Where nothing answers.
static NOTHING: Block = NONE;
const NONE: Block = block(0, |_, _| None, |_, _, _| Written::NotModelled);

static DMA_BLOCK: Block =
    block(bit::DMA, |bus, at| bus.dma.read(at), |bus, at, write| bus.dma.write(at, write, bus.now));

const APB_BLOCKS: usize = 28;

/// From 0x4000_0000 on.
static BEHIND_APB: [Block; APB_BLOCKS] = [
    // 0x4000_0000: SYSINFO
    block(bit::SYSINFO, |bus, at| bus.sysinfo.read(at), |bus, at, write| bus.sysinfo.write(at, write)),
    // 0x4000_4000: SYSCFG
    block(bit::SYSCFG, |bus, at| bus.syscfg.read(at), |bus, at, write| bus.syscfg.write(at, write)),
    // 0x4000_8000: CLOCKS
    block(
        0,
        |bus, at| bus.clocks.read(at),
        |bus, at, write| {
            let written = bus.clocks.write(at, write);
            bus.clocks_written(written)
        },
    ),
    // 0x4000_c000: RESETS
    block(
        0,
        |bus, at| bus.resets.read(at),
        |bus, at, write| {
            let (written, newly_held) = bus.resets.write(at, write);
            bus.reset_peripherals(newly_held);
            written
        },
    ),
    // 0x4001_0000: PSM
    block(
        0,
        |bus, at| bus.psm.read(at),
        |bus, at, write| {
            let written = bus.psm.write(at, write);
            if bus.psm.holds_sio() {
                bus.reset_sio();
            }
            written
        },
    ),
    // 0x4001_4000: IO_BANK0
    block(
        bit::IO_BANK0,
        |bus, at| {
            bus.catch_up();
            let (outputs, enables) = bus.driven_pins();
            bus.io.read(at, outputs, enables)
        },
        |bus, at, write| {
            let written = bus.io.write(at, write);
            bus.pin_functions_changed();
            written
        },
    ),
    // 0x4001_8000: IO_QSPI
    NONE,
    // 0x4001_c000: PADS_BANK0
    block(
        bit::PADS_BANK0,
        |bus, at| bus.pads.read(at),
        |bus, at, write| {
            let written = bus.pads.write(at, write);
            bus.update_pins();
            written
        },
    ),
    // 0x4002_0000: PADS_QSPI
    block(0, |bus, at| bus.pads_qspi.read(at), |bus, at, write| bus.pads_qspi.write(at, write)),
    // 0x4002_4000: XOSC
    block(
        0,
        |bus, at| {
            bus.catch_up();
            bus.xosc.read(at, bus.now)
        },
        |bus, at, write| bus.xosc.write(at, write, bus.now),
    ),
    // 0x4002_8000: PLL_SYS
    block(
        bit::PLL_SYS,
        |bus, at| bus.pll_sys.read(at),
        |bus, at, write| {
            let written = bus.pll_sys.write(at, write);
            bus.clocks_written(written)
        },
    ),
    // 0x4002_c000: PLL_USB
    block(
        bit::PLL_USB,
        |bus, at| bus.pll_usb.read(at),
        |bus, at, write| {
            let written = bus.pll_usb.write(at, write);
            bus.clocks_written(written)
        },
    ),
    // 0x4003_0000: BUSCTRL
    NONE,
    // 0x4003_4000: UART0
    taking(
        Takes::At(uart::UARTDR),
        block(
            bit::UART0,
            |bus, at| bus.uarts[0].read(at),
            |bus, at, write| bus.uarts[0].write(at, write, bus.now),
        ),
    ),
    // 0x4003_8000: UART1
    taking(
        Takes::At(uart::UARTDR),
        block(
            bit::UART1,
            |bus, at| bus.uarts[1].read(at),
            |bus, at, write| bus.uarts[1].write(at, write, bus.now),
        ),
    ),
    // 0x4003_c000: SPI0
    block(bit::SPI0, |bus, at| bus.spi[0].read(at), |bus, at, write| bus.spi[0].write(at, write)),
    // 0x4004_0000: SPI1
    block(bit::SPI1, |bus, at| bus.spi[1].read(at), |bus, at, write| bus.spi[1].write(at, write)),
    // 0x4004_4000: I2C0
    taking(
        Takes::Always,
        block(
            bit::I2C0,
            |bus, at| bus.i2c[0].read(at),
            |bus, at, write| bus.i2c[0].write(at, write, bus.now),
        ),
    ),
    // 0x4004_8000: I2C1
    taking(
        Takes::Always,
        block(
            bit::I2C1,
            |bus, at| bus.i2c[1].read(at),
            |bus, at, write| bus.i2c[1].write(at, write, bus.now),
        ),
    ),
    // 0x4004_c000: ADC
    taking(
        Takes::At(adc::FIFO),
        block(bit::ADC, |bus, at| bus.adc.read(at), |bus, at, write| bus.adc.write(at, write, bus.now)),
    ),
    // 0x4005_0000: PWM
    block(
        bit::PWM,
        |bus, at| {
            bus.catch_up();
            bus.pwm.read(at, bus.now)
        },
        |bus, at, write| {
            let written = bus.pwm.write(at, write, bus.now);
            bus.update_pwm_pins(bus.now);
            written
        },
    ),
    // 0x4005_4000: TIMER
    block(
        bit::TIMER,
        |bus, at| {
            bus.catch_up();
            bus.timer.read(at, bus.now)
        },
        |bus, at, write| bus.timer.write(at, write, bus.now),
    ),
    // 0x4005_8000: WATCHDOG
    block(
        0,
        |bus, at| {
            bus.catch_up();
            bus.watchdog.read(at, bus.now)
        },
        |bus, at, write| {
            let written = bus.watchdog.write(at, write, bus.now);
            bus.update_tick();
            written
        },
    ),
    // 0x4005_c000: RTC
    NONE,
    // 0x4006_0000: ROSC
    block(
        0,
        |bus, at| bus.rosc.read(at),
        |bus, at, write| {
            let written = bus.rosc.write(at, write);
            bus.clocks_written(written)
        },
    ),
    // 0x4006_4000: VREG_AND_CHIP_RESET
    block(0, |bus, at| bus.vreg.read(at), |bus, at, write| bus.vreg.write(at, write)),
    // 0x4006_8000
    NONE,
    // 0x4006_c000: TBMAN
    block(bit::TBMAN, |bus, at| bus.tbman.read(at), |bus, at, write| bus.tbman.write(at, write)),
];
