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

/// Waits for `settle_s`, then takes readings for a second.
pub fn reading(
    poller: &Poller,
    (board, channel): (u8, usize),
    settle_s: f64,
    stop: impl Fn() -> bool,
) -> Result<Settled, String> {
    const LOOK_EVERY: Duration = Duration::from_millis(10);
    const TAKEN: Duration = Duration::from_secs(1);
    let begin = Instant::now() + Duration::from_secs_f64(settle_s);
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
    of(&counts).ok_or_else(|| format!("board {board} did not answer while it was to be read"))
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
}
