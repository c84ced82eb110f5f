//! The pin map: which pin does what, in one place. `docs/firmware.md` has the same table with the
//! wiring.
//!
//! | GPIO | role | while nothing drives it |
//! | --- | --- | --- |
//! | 0 | bus, UART0 transmit; starts the 555 | pull-up on the board: line idle |
//! | 1 | bus, UART0 receive | |
//! | 2 | bus, driver enable (for boards without the 555) | pull-down inside: driver off |
//! | 4, 5 | I2C0 SDA, SCL: broken out for further sensors | pull-ups at the connector |
//! | 6, 8, 10, 12 | PWM of valves 0 to 3 (channel A of slices 3 to 6) | pull-up on the board: vent |
//! | 7, 9, 11, 13 | DIR of valves 0 to 3 | pull-up on the board: vent |
//! | 14, 15 | address switch, first and second; closed is low | |
//! | 25 | status LED | |
//! | 26 to 29 | pressures 0 to 3 (ADC 0 to 3) | |

use crate::bus::BusHardware;
use crate::i2c::Lines;
use crate::sensors::SensorHardware;
use crate::valves::Valve;
use embassy_rp::adc::Channel;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::peripherals::{FLASH, WATCHDOG};
use embassy_rp::{Peri, Peripherals};
use embassy_time::Timer;
use pneudrive_protocol::Address;

/// The chip's hardware, by the part of the firmware that uses it.
pub struct Hardware {
    /// UART, driver enable, and two DMA channels.
    pub bus: BusHardware,
    /// DIR and PWM of the four valves.
    pub valves: [Valve; 4],
    /// ADC, its four inputs, and a DMA channel.
    pub sensors: SensorHardware,
    /// The lines of the I2C connector, and their block.
    pub i2c: Lines,
    /// The address switch.
    pub switch: AddressSwitch,
    /// The status LED.
    pub led: Output<'static>,
    /// The watchdog.
    pub watchdog: Peri<'static, WATCHDOG>,
    /// The flash, whose last two sectors keep the parameters.
    pub flash: Peri<'static, FLASH>,
}

impl Hardware {
    /// Hands out the pins. The valve pins go on driving full vent as they change from GPIO to PWM.
    pub fn split(p: Peripherals) -> Self {
        Self {
            bus: BusHardware {
                uart: p.UART0,
                transmit: p.PIN_0,
                receive: p.PIN_1,
                driver_enable: Output::new(p.PIN_2, Level::Low),
                characters: p.DMA_CH0,
                stamps: p.DMA_CH1,
            },
            valves: [
                Valve::new(Output::new(p.PIN_7, Level::High), p.PWM_SLICE3, p.PIN_6),
                Valve::new(Output::new(p.PIN_9, Level::High), p.PWM_SLICE4, p.PIN_8),
                Valve::new(Output::new(p.PIN_11, Level::High), p.PWM_SLICE5, p.PIN_10),
                Valve::new(Output::new(p.PIN_13, Level::High), p.PWM_SLICE6, p.PIN_12),
            ],
            sensors: SensorHardware {
                adc: p.ADC,
                inputs: [
                    Channel::new_pin(p.PIN_26, Pull::None),
                    Channel::new_pin(p.PIN_27, Pull::None),
                    Channel::new_pin(p.PIN_28, Pull::None),
                    Channel::new_pin(p.PIN_29, Pull::None),
                ],
                temperature: p.ADC_TEMP_SENSOR,
                readings: p.DMA_CH2,
            },
            i2c: Lines { block: p.I2C0, sda: p.PIN_4, scl: p.PIN_5 },
            switch: AddressSwitch {
                first: Input::new(p.PIN_14, Pull::Up),
                second: Input::new(p.PIN_15, Pull::Up),
            },
            led: Output::new(p.PIN_25, Level::Low),
            watchdog: p.WATCHDOG,
            flash: p.FLASH,
        }
    }
}

/// The two-way switch that sets the board's address.
pub struct AddressSwitch {
    first: Input<'static>,
    second: Input<'static>,
}

impl AddressSwitch {
    /// The address it stands at.
    pub async fn read(&self) -> Address {
        // The pull-ups (80 kohm at most) against the pins' and traces' capacitance: a few us.
        Timer::after_micros(100).await;
        Address::of_switch(self.first.is_low(), self.second.is_low())
    }
}
