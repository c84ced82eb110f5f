//! What `pneudrive-model watch` finds on virtual rigs: false alarms of healthy ones, and how long
//! it takes for a change of which size.
//!
//! `watch_table healthy RIGS HOURS SEED [loop]` watches so many rigs for so many hours each;
//! `watch_table faults RIGS SEED [EFFECT..] [loop]` makes each change, or these, at four sizes on
//! so many rigs; `watch_table cost` measures what a row of 16 chambers at 1 kHz takes. With `loop`
//! the drives are not recorded. All are in docs/watch.md.

#![allow(clippy::unwrap_used, reason = "a measurement that cannot be made is a failure")]

mod cost;
mod faults;
mod healthy;
mod rig;

use rig::{Kind, STEP_NS};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |place: usize| words.get(place).and_then(|word| word.parse::<f64>().ok());
    let drive = words.last().is_none_or(|word| word != "loop");
    let kind = Kind { channels: 2, rate_hz: 100.0, drive, step_ns: STEP_NS };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // counts
    let count = |value: f64| value as u64;
    match (words.first().map(String::as_str), number(1), number(2), number(3)) {
        (Some("healthy"), Some(rigs), Some(hours), Some(seed)) => {
            healthy::run(Kind { channels: 1, ..kind }, count(seed)..count(seed + rigs), hours);
        }
        (Some("faults"), Some(rigs), Some(seed), _) => {
            let only: Vec<String> = words.iter().skip(3).filter(|word| *word != "loop").cloned().collect();
            faults::run(kind, count(seed)..count(seed + rigs), &only);
        }
        (Some("cost"), ..) => cost::run(),
        _ => {
            eprintln!(
                "expected: healthy RIGS HOURS SEED [loop], faults RIGS SEED [EFFECT..] [loop], or cost"
            );
            std::process::exit(2);
        }
    }
}

/// The largest mean of a Poisson distribution that so few counts leave possible, 95 % (one-sided,
/// exact).
fn poisson_upper95(count: u32) -> f64 {
    let at_most = |mean: f64| {
        let mut term = (-mean).exp();
        let mut sum = term;
        for k in 1..=count {
            term *= mean / f64::from(k);
            sum += term;
        }
        sum
    };
    let (mut low, mut high) = (0.0, 10.0 + 4.0 * f64::from(count));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if at_most(middle) > 0.05 { low = middle } else { high = middle }
    }
    high
}
