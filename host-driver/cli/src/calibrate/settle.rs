//! A reading that has come to rest.

use pneudrive_host::poller::Poller;
use std::time::{Duration, Instant};

/// What a channel reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// Mean, counts.
    pub mean: f64,
    /// Standard deviation of single readings, counts.
    pub spread: f64,
}

/// Why there is no reading.
#[derive(Debug, PartialEq, Eq)]
pub enum Unread {
    /// Nothing can be read any more.
    Ended(String),
    /// The pressure does not stay where it was commanded.
    Restless(String),
}

/// The halves of a second's readings may differ by this much, counts. Noise of single readings
/// moves their means by a tenth of it.
const MOST_DRIFT: f64 = 0.5;
/// A loop at rest is within this of its set point, counts (17 kPa): further off it vents, or has no
/// supply.
const MOST_DEVIATION: f64 = 20.0;
/// After the time to settle, so many seconds are looked at before a channel is given up.
const SECONDS: usize = 8;

/// Waits for `settle_s`, then for a second in which the pressure is at rest near `commanded`.
pub fn reading(
    poller: &Poller,
    (board, channel): (u8, usize),
    commanded: f64,
    settle_s: f64,
    stop: impl Fn() -> bool,
) -> Result<Settled, Unread> {
    let mut begin = Instant::now() + Duration::from_secs_f64(settle_s);
    let mut unread = Unread::Restless(String::new());
    for _ in 0..SECONDS {
        let counts = a_second(poller, (board, channel), begin, &stop).map_err(Unread::Ended)?;
        let silent = || Unread::Ended(format!("board {board} did not answer while it was to be read"));
        let settled = of(&counts).ok_or_else(silent)?;
        match unrest(&counts, commanded) {
            None => return Ok(settled),
            Some(why) => unread = Unread::Restless(why),
        }
        begin = Instant::now();
    }
    Err(unread)
}

/// Readings of the second after `begin`, counts.
fn a_second(
    poller: &Poller,
    (board, channel): (u8, usize),
    begin: Instant,
    stop: impl Fn() -> bool,
) -> Result<Vec<f64>, String> {
    const LOOK_EVERY: Duration = Duration::from_millis(10);
    const TAKEN: Duration = Duration::from_secs(1);
    let mut counts: Vec<f64> = Vec::new();
    let mut last = None;
    while Instant::now() < begin + TAKEN {
        if stop() {
            return Err("interrupted".to_owned());
        }
        if poller.is_finished() {
            return Err("the port failed".to_owned());
        }
        std::thread::sleep(LOOK_EVERY);
        if Instant::now() < begin {
            continue;
        }
        let latest = poller.latest();
        let row = latest.boards.iter().find(|row| row.board == board);
        if let Some(reading) = row.and_then(|row| row.fresh())
            && last.replace(reading.asked_ns) != Some(reading.asked_ns)
        {
            counts.push(f64::from(reading.counts[channel].get()));
        }
    }
    Ok(counts)
}

/// What says that a pressure is not at rest where it was commanded.
fn unrest(counts: &[f64], commanded: f64) -> Option<String> {
    let (early, late) = counts.split_at(counts.len() / 2);
    let (early, late) = (of(early)?.mean, of(late)?.mean);
    if (late - early).abs() > MOST_DRIFT {
        return Some(format!("it still moves, by {:.1} counts in half a second", (late - early).abs()));
    }
    let deviation = late - commanded;
    (deviation.abs() > MOST_DEVIATION)
        .then(|| format!("it rests at {late:.0} counts, {commanded:.0} were commanded: is there supply?"))
}

fn of(counts: &[f64]) -> Option<Settled> {
    let count = counts.len() as f64;
    if counts.is_empty() {
        return None;
    }
    let mean = counts.iter().sum::<f64>() / count;
    let squares = counts.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    Some(Settled { mean, spread: (squares / (count - 1.0).max(1.0)).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_spread() {
        let settled = of(&[339.0, 340.0, 341.0]).unwrap();
        assert!((settled.mean - 340.0).abs() < 1e-12 && (settled.spread - 1.0).abs() < 1e-12);
        assert_eq!(of(&[340.0]), Some(Settled { mean: 340.0, spread: 0.0 }));
        assert_eq!(of(&[]), None);
    }

    #[test]
    fn what_moves_or_rests_elsewhere_is_no_reading() {
        let noisy: Vec<f64> = (0..100).map(|k| 164.0 + f64::from(k % 2)).collect();
        assert_eq!(unrest(&noisy, 161.8), None);
        let rising: Vec<f64> = (0..100).map(|k| 150.0 + f64::from(k) * 0.2).collect();
        assert!(unrest(&rising, 161.8).unwrap().contains("moves, by 10.0 counts"));
        let vented = [102.0; 100];
        assert!(unrest(&vented, 161.8).unwrap().contains("rests at 102 counts, 162 were commanded"));
    }
}
