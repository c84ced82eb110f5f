//! What stands on pins over time.

use pneudrive_chip::{Level, Ticks};
use system_tests::chip_bench::{CHARACTER, ChipBench};

/// What a probe sees, and whose doing it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// The chip drives the pin.
    Driven(bool),
    /// The board's pull-up or pull-down, or another chip, does.
    Released(bool),
}

impl State {
    /// High or low.
    pub fn is_high(self) -> bool {
        matches!(self, State::Driven(true) | State::Released(true))
    }
}

/// One trace: states and the times from which on they hold, us.
#[derive(Debug, Clone)]
pub struct Trace {
    /// What the probe is at.
    pub name: String,
    /// In order of time.
    pub changes: Vec<(f64, State)>,
}

impl Trace {
    /// The times at which the level rises (or falls), us.
    pub fn edges(&self, rising: bool) -> impl Iterator<Item = f64> + '_ {
        let pairs = self
            .changes
            .windows(2)
            .filter(move |pair| pair[0].1.is_high() != pair[1].1.is_high() && pair[1].1.is_high() == rising);
        pairs.map(|pair| pair[1].0)
    }

    /// When the chip first drives the pin, us.
    pub fn first_driven(&self) -> Option<f64> {
        self.changes.iter().find(|(_, state)| matches!(state, State::Driven(_))).map(|(at, _)| *at)
    }
}

/// Runs the chip until `until`, and watches pins.
pub fn pins(bench: &mut ChipBench, pins: &[(usize, &str)], until: Ticks) -> Vec<Trace> {
    let mut traces: Vec<Trace> = pins
        .iter()
        .map(|(pin, name)| Trace { name: format!("GPIO {pin}  {name}"), changes: Vec::new() })
        .collect();
    // Then the edges of PWM are events, too.
    bench.chip.watch_pins(pins.iter().fold(0, |set, (pin, _)| set | 1 << pin));
    loop {
        let now = bench.chip.now();
        for (trace, (pin, _)) in traces.iter_mut().zip(pins) {
            let state = match bench.chip.pin_output(*pin) {
                Level::Floating => State::Released(bench.chip.pin_level(*pin) == Level::High),
                driven => State::Driven(driven == Level::High),
            };
            if trace.changes.last().is_none_or(|(_, last)| *last != state) {
                trace.changes.push((now.as_micros(), state));
            }
        }
        if now >= until {
            return traces;
        }
        bench.chip.run_until(bench.chip.next_event().min(until).max(now + Ticks::new(1)));
    }
}

/// The levels of characters on a line: bytes, and the times of their last stop bits' ends.
pub fn characters(name: &str, from: Ticks, characters: &[(u8, Ticks)]) -> Trace {
    let mut changes = vec![(from.as_micros(), State::Driven(true))];
    let bit_us = CHARACTER.as_micros() / 10.0;
    for (byte, end) in characters {
        let start = end.saturating_sub(CHARACTER).as_micros();
        let bits = std::iter::once(false).chain((0..8).map(|bit| byte >> bit & 1 == 1)).chain([true]);
        for (number, high) in bits.enumerate() {
            changes.push((start + bit_us * number as f64, State::Driven(high)));
        }
    }
    Trace { name: name.to_owned(), changes }
}
