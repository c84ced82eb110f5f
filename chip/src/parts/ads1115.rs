use super::I2cPart;
use crate::ticks::Ticks;

/// Offsets in the address pointer register (TI SBAS444 table 8-2).
const CONVERSION: u8 = 0;
const CONFIG: u8 = 1;
const LO_THRESH: u8 = 2;
const HI_THRESH: u8 = 3;

/// Config register (table 8-3).
const OS: u16 = 1 << 15;
const SINGLE_SHOT: u16 = 1 << 8;
const CONFIG_RESET: u16 = 0x8583;

/// Texas Instruments ADS1115: a 16-bit analogue-to-digital converter with four inputs.
///
/// Modelled: conversion, configuration and threshold registers, single-shot and continuous
/// conversions at the nominal data rates, all inputs and ranges. A conversion has the voltages that
/// its inputs have when it ends, as far as anybody looks; the comparator and its pin do nothing,
/// and offset, gain and noise are those of an ideal part.
#[derive(Clone, Debug)]
pub struct Ads1115 {
    inputs_uv: [i32; 4],
    pointer: u8,
    config: u16,
    thresholds: [u16; 2],
    conversion: u16,
    /// End of the conversion that is going on.
    converting_until: Option<Ticks>,
    /// Bytes of the present transfer.
    written: Vec<u8>,
    sent: usize,
    conversions: u64,
}

impl Default for Ads1115 {
    fn default() -> Self {
        Self::new()
    }
}

impl Ads1115 {
    /// As it is after power-on, with 0 V at all inputs.
    pub fn new() -> Ads1115 {
        Ads1115 {
            inputs_uv: [0; 4],
            pointer: CONVERSION,
            config: CONFIG_RESET,
            thresholds: [0x8000, 0x7fff],
            conversion: 0,
            converting_until: None,
            written: Vec::new(),
            sent: 0,
            conversions: 0,
        }
    }

    /// The voltage at input AIN0 to AIN3 from now on, microvolts.
    ///
    /// # Panics
    ///
    /// If there is no such input.
    pub fn set_input_uv(&mut self, input: usize, microvolts: i32) {
        self.inputs_uv[input] = microvolts;
    }

    /// Conversions that have ended, as far as anybody looked.
    pub fn conversions(&self) -> u64 {
        self.conversions
    }

    /// Positive and negative input (MUX).
    fn voltage_uv(&self) -> i64 {
        let input = |n: usize| i64::from(self.inputs_uv[n]);
        match self.config >> 12 & 7 {
            0 => input(0) - input(1),
            1 => input(0) - input(3),
            2 => input(1) - input(3),
            3 => input(2) - input(3),
            single => input(usize::from(single) - 4),
        }
    }

    /// Full scale (PGA), microvolts.
    fn full_scale_uv(&self) -> i64 {
        match self.config >> 9 & 7 {
            0 => 6_144_000,
            1 => 4_096_000,
            2 => 2_048_000,
            3 => 1_024_000,
            4 => 512_000,
            _ => 256_000,
        }
    }

    /// Duration of a conversion (DR).
    fn conversion_time(&self) -> Ticks {
        const RATES: [u64; 8] = [8, 16, 32, 64, 128, 250, 475, 860];
        Ticks::new(Ticks::PER_SECOND / RATES[usize::from(self.config >> 5 & 7)])
    }

    fn is_continuous(&self) -> bool {
        self.config & SINGLE_SHOT == 0
    }

    /// Ends conversions that are due.
    fn catch_up(&mut self, now: Ticks) {
        while let Some(until) = self.converting_until.filter(|until| *until <= now) {
            let codes = (2 * self.voltage_uv() * 32_768 / self.full_scale_uv() + 1).div_euclid(2);
            self.conversion = (codes.clamp(-32_768, 32_767) as i16).cast_unsigned();
            self.conversions += 1;
            self.converting_until = self.is_continuous().then(|| until + self.conversion_time());
        }
    }

    fn register(&self) -> u16 {
        match self.pointer {
            CONVERSION => self.conversion,
            CONFIG => self.config & !OS | if self.converting_until.is_none() { OS } else { 0 },
            LO_THRESH => self.thresholds[0],
            _ => self.thresholds[1],
        }
    }

    fn write_register(&mut self, now: Ticks, value: u16) {
        match self.pointer {
            CONFIG => {
                let starts = value & SINGLE_SHOT == 0 || value & OS != 0;
                self.config = value;
                self.converting_until = starts.then(|| now + self.conversion_time());
            }
            LO_THRESH => self.thresholds[0] = value,
            HI_THRESH => self.thresholds[1] = value,
            _ => {}
        }
    }
}

impl I2cPart for Ads1115 {
    fn start(&mut self, now: Ticks, _read: bool) -> bool {
        self.catch_up(now);
        self.written.clear();
        self.sent = 0;
        true
    }

    fn write(&mut self, now: Ticks, byte: u8) -> bool {
        self.catch_up(now);
        self.written.push(byte);
        match self.written[..] {
            [pointer] => self.pointer = pointer & 3,
            [_, high, low] => self.write_register(now, u16::from_be_bytes([high, low])),
            _ => {}
        }
        true
    }

    fn read(&mut self, now: Ticks) -> u8 {
        self.catch_up(now);
        let byte = self.register().to_be_bytes()[self.sent % 2];
        self.sent += 1;
        byte
    }
}
