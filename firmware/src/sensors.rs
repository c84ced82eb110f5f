//! Four pressure sensors on the ADC, read in turn by DMA, and the chip's temperature sensor.

use crate::config::OVERSAMPLING;
use embassy_rp::adc::{self, Adc, Async, Channel, InterruptHandler};
use embassy_rp::peripherals::{ADC, ADC_TEMP_SENSOR, DMA_CH2};
use embassy_rp::{Peri, bind_interrupts, dma};
use pneudrive_control::AdcSample;

bind_interrupts!(struct Interrupts {
    ADC_IRQ_FIFO => InterruptHandler;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH2>;
});

/// What the sensors need of the chip.
pub struct SensorHardware {
    /// The converter.
    pub adc: Peri<'static, ADC>,
    /// The four inputs, in order.
    pub inputs: [Channel<'static>; 4],
    /// The chip's own sensor.
    pub temperature: Peri<'static, ADC_TEMP_SENSOR>,
    /// Carries the readings.
    pub readings: Peri<'static, DMA_CH2>,
}

/// Reads all four sensors, and the chip's.
pub struct Sensors {
    adc: Adc<'static, Async>,
    inputs: [Channel<'static>; 4],
    temperature: Channel<'static>,
    dma: dma::Channel<'static>,
    rounds: [[u16; 4]; OVERSAMPLING],
}

impl Sensors {
    /// Switches the ADC on.
    pub fn new(hardware: SensorHardware) -> Self {
        let adc = Adc::new(hardware.adc, Interrupts, adc::Config::default());
        Self {
            adc,
            // Only now: the start of the ADC takes its power away.
            temperature: Channel::new_temp_sensor(hardware.temperature),
            inputs: hardware.inputs,
            dma: dma::Channel::new(hardware.readings, Interrupts),
            rounds: [[0; 4]; OVERSAMPLING],
        }
    }

    /// Converts as fast as the ADC can (2 us a reading), and averages.
    ///
    /// # Errors
    /// A conversion did not settle (RP2040 datasheet 4.9.2.1, ERR).
    pub async fn sample(&mut self) -> Result<[AdcSample; 4], adc::Error> {
        let readings = self.rounds.as_flattened_mut();
        self.adc.read_many_multichannel(&mut self.inputs, readings, 0, &mut self.dma).await?;
        Ok(AdcSample::from_rounds(&self.rounds))
    }

    /// One reading of the chip's temperature, 12 bits: waits 2 us for it.
    ///
    /// # Errors
    /// As for [`sample`](Self::sample).
    pub fn chip_temperature(&mut self) -> Result<u16, adc::Error> {
        self.adc.blocking_read(&mut self.temperature)
    }
}
