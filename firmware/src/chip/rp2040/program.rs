//! What a program begins with (`pneudrive_protocol::program`): vectors, what it is, and its first
//! instructions.

use crate::chip::KIND;
use pneudrive_control::Identity;
use pneudrive_protocol::program::{HEADER_AT, MAGIC};

/// An entry of the vector table.
#[derive(Clone, Copy)]
union Vector {
    handler: unsafe extern "C" fn(),
    symbol: *const u32,
    reserved: u32,
}

// SAFETY: never written by the processor's own code but by the boot stage, before the program runs.
unsafe impl Sync for Vector {}

/// The processor's exceptions, and the interrupts that the chip has: 26, and six that software
/// raises.
macro_rules! vectors {
    ($($interrupt:ident)*) => {
        unsafe extern "C" {
            static _stack_start: u32;
            fn program_start();
            fn NonMaskableInt();
            fn HardFault();
            fn SVCall();
            fn PendSV();
            fn SysTick();
            $(fn $interrupt();)*
        }

        /// Named, so that the linker script finds it.
        #[unsafe(no_mangle)]
        #[unsafe(link_section = ".program.vectors")]
        static PROGRAM_VECTORS: [Vector; HEADER_AT / 4] = {
            const UNUSED: Vector = Vector { reserved: 0 };
            [
                Vector { symbol: &raw const _stack_start },
                Vector { handler: program_start },
                Vector { handler: NonMaskableInt },
                Vector { handler: HardFault },
                UNUSED,
                UNUSED,
                UNUSED,
                UNUSED,
                UNUSED,
                UNUSED,
                UNUSED,
                Vector { handler: SVCall },
                UNUSED,
                UNUSED,
                Vector { handler: PendSV },
                Vector { handler: SysTick },
                $(Vector { handler: $interrupt },)*
            ]
        };
    };
}

vectors! {
    TIMER_IRQ_0 TIMER_IRQ_1 TIMER_IRQ_2 TIMER_IRQ_3 PWM_IRQ_WRAP USBCTRL_IRQ XIP_IRQ PIO0_IRQ_0
    PIO0_IRQ_1 PIO1_IRQ_0 PIO1_IRQ_1 DMA_IRQ_0 DMA_IRQ_1 IO_IRQ_BANK0 IO_IRQ_QSPI SIO_IRQ_PROC0
    SIO_IRQ_PROC1 CLOCKS_IRQ SPI0_IRQ SPI1_IRQ UART0_IRQ UART1_IRQ ADC_IRQ_FIFO I2C0_IRQ
    I2C1_IRQ RTC_IRQ SWI_IRQ_0 SWI_IRQ_1 SWI_IRQ_2 SWI_IRQ_3 SWI_IRQ_4 SWI_IRQ_5
}

#[unsafe(no_mangle)]
#[unsafe(link_section = ".program.magic")]
static PROGRAM_MAGIC: u32 = MAGIC;

/// Chip and version. Between them and the mark the linker script puts the length.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".program.about")]
static PROGRAM_ABOUT: [u32; 2] = {
    let [major, minor, patch] = Identity::of_chip(KIND).about.version;
    [KIND.number() as u32, (major as u32) << 20 | (minor as u32) << 10 | patch as u32]
};

core::arch::global_asm!(
    ".section .program.start, \"ax\"",
    ".global program_start",
    ".type program_start,%function",
    ".thumb_func",
    "program_start:",
    "ldr r0, =__sbss",
    "ldr r1, =__ebss",
    "movs r2, #0",
    "0:",
    "cmp r0, r1",
    "bhs 1f",
    "stm r0!, {{r2}}",
    "b 0b",
    "1:",
    "bl main",
    "udf #0",
    ".pool",
    ".size program_start, . - program_start",
);
