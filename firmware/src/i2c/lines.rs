//! SDA and SCL: by the I2C block, or by hand.

use embassy_rp::Peri;
use embassy_rp::bind_interrupts;
use embassy_rp::gpio::{Flex, Pull};
use embassy_rp::i2c::{Async, Config, I2c, InterruptHandler};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::peripherals::{I2C0, PIN_4, PIN_5};
use embassy_time::Timer;

bind_interrupts!(struct Interrupts {
    I2C0_IRQ => InterruptHandler<I2C0>;
});

/// Slow enough for some metres of cable and every level shifter.
const FREQUENCY_HZ: u32 = 100_000;
/// Half a clock by hand.
const HALF_CLOCK_US: u64 = 5;
/// A byte and its acknowledgement (I2C specification UM10204, 3.1.16).
const CLOCKS: u8 = 9;

/// The I2C block while it has the lines.
pub type Master<'d> = I2c<'d, I2C0, Async>;

/// The connector's two lines and the block that they are wired to.
pub struct Lines {
    /// The block.
    pub block: Peri<'static, I2C0>,
    /// Data.
    pub sda: Peri<'static, PIN_4>,
    /// Clock.
    pub scl: Peri<'static, PIN_5>,
}

impl Lines {
    /// Gives the lines to the block, which is reset.
    pub(super) fn open(&mut self) -> Master<'_> {
        interrupt::I2C0_IRQ.set_priority(Priority::P3);
        let mut config = Config::default();
        config.frequency = FREQUENCY_HZ;
        I2c::new_async(self.block.reborrow(), self.scl.reborrow(), self.sda.reborrow(), Interrupts, config)
    }

    /// Clocks whoever holds SDA in the middle of a byte to its end, and ends the transfer. Gives
    /// whether SDA is free.
    pub(super) async fn free(&mut self) -> bool {
        let (mut sda, mut scl) = (Flex::new(self.sda.reborrow()), Flex::new(self.scl.reborrow()));
        for line in [&mut sda, &mut scl] {
            // Low or let go, never high.
            line.set_low();
            line.set_as_input();
            line.set_pull(Pull::Up);
        }
        half_clock().await;
        for _ in 0..CLOCKS {
            if sda.is_high() {
                break;
            }
            scl.set_as_output();
            half_clock().await;
            scl.set_as_input();
            half_clock().await;
        }
        let free = sda.is_high() && scl.is_high();
        // SDA down and up while SCL is high: a START and a STOP.
        sda.set_as_output();
        half_clock().await;
        sda.set_as_input();
        half_clock().await;
        free
    }
}

async fn half_clock() {
    Timer::after_micros(HALF_CLOCK_US).await;
}
