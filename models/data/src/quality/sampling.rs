//! How regularly the recording was sampled, and where time is missing.

use serde::{Deserialize, Serialize};

use super::finding::{Finding, FindingKind, Span, rows_text};

/// A step longer than this many nominal periods is reported as a gap.
pub(crate) const GAP_PERIODS: f64 = 1.5;

/// Inputs are held over a gap up to this many nominal periods: a board holds its last command, and
/// a drive changes little in that time. A longer gap ends the stretch, and the simulation starts
/// anew from a measured pressure.
pub(crate) const BRIDGED_PERIODS: f64 = 5.5;

/// Inputs are held over a gap up to this long at any rate, s: as long as at 500 Hz. A bus that is
/// polled as fast as it goes is late by some milliseconds now and then, which are many of its
/// periods and nothing to a chamber.
const BRIDGED_S: f64 = 0.01;

/// The time axis in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sampling {
    /// Nominal sampling rate, 1 / median step, Hz.
    pub rate_hz: f64,
    /// Standard deviation of the steps that are not gaps, s.
    pub jitter_s: f64,
    /// Longest step, s.
    pub longest_step_s: f64,
    /// Steps longer than 1.5 nominal periods.
    pub gaps: usize,
}

impl Sampling {
    /// The time axis in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!(
            "Sampled at {} Hz, step jitter {} ms (standard deviation), longest step {} ms.",
            digits(self.rate_hz),
            digits(1e3 * self.jitter_s),
            digits(1e3 * self.longest_step_s)
        )
    }
}

/// Three or four significant digits without an exponent.
fn digits(value: f64) -> String {
    let decimals = if value.abs() >= 100.0 {
        1
    } else if value.abs() >= 1.0 {
        2
    } else {
        4
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Measures the steps of a strictly increasing time axis of at least two rows.
pub(crate) fn sampling(time_s: &[f64]) -> Sampling {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let longest_step_s = steps.iter().copied().fold(0.0, f64::max);
    let middle = steps.len() / 2;
    let (_, &mut period, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let gap = GAP_PERIODS * period;
    let (mut n, mut mean, mut squares) = (0.0, 0.0, 0.0);
    for &step in steps.iter().filter(|s| **s <= gap) {
        n += 1.0;
        let off: f64 = step - mean;
        mean += off / n;
        squares += off * (step - mean);
    }
    let gaps = steps.iter().filter(|s| **s > gap).count();
    let jitter_s = if n > 1.0 { (squares / (n - 1.0)).sqrt() } else { 0.0 };
    // Below the resolution of decimal time stamps in f64 there is no jitter, only rounding.
    let jitter_s = if jitter_s < 1e-9 { 0.0 } else { jitter_s };
    Sampling { rate_hz: period.recip(), jitter_s, longest_step_s, gaps }
}

/// Rows that begin a new stretch, and what is said about missing time.
pub(crate) fn find_breaks(time_s: &[f64], line: &[u32], sampling: &Sampling) -> (Vec<usize>, Vec<Finding>) {
    let period = sampling.rate_hz.recip();
    let mut breaks = Vec::new();
    let mut spans = Vec::new();
    let mut missing_s = 0.0;
    for row in 1..time_s.len() {
        let step = time_s[row] - time_s[row - 1];
        if step > GAP_PERIODS * period {
            missing_s += step - period;
            spans.push(Span {
                first_row: line[row - 1],
                last_row: line[row],
                from_s: time_s[row - 1],
                to_s: time_s[row],
            });
            if step > BRIDGED_PERIODS * period && step > BRIDGED_S {
                breaks.push(row);
            }
        }
    }
    let mut findings = Vec::new();
    if !spans.is_empty() {
        let bridged = spans.len() - breaks.len();
        let sentence = format!(
            "{} {} longer than {GAP_PERIODS} sampling periods, {} s in all, {:.1} % of the time ({}): inputs are held over {bridged}, the simulation starts anew after {}.",
            spans.len(),
            if spans.len() == 1 { "gap is" } else { "gaps are" },
            digits(missing_s),
            100.0 * missing_s / (time_s[time_s.len() - 1] - time_s[0]),
            rows_text(&spans),
            breaks.len(),
        );
        findings.push(Finding::new(FindingKind::Gap, None, spans.len(), spans, sentence));
    }
    if !(2.0..=50_000.0).contains(&sampling.rate_hz) {
        let sentence = format!(
            "A sampling rate of {} Hz is unusual for pressures: t_s must be in seconds; import times in ms or us with `pneudrive-model import --time`.",
            digits(sampling.rate_hz)
        );
        findings.push(Finding::new(FindingKind::OddRate, None, time_s.len(), Vec::new(), sentence));
    }
    (breaks, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_jitter_and_gaps_are_measured() {
        // 100 Hz with +-0.1 ms of alternating jitter, one lost row and one long pause.
        let mut time: Vec<f64> =
            (0..1000).map(|k| 0.01 * f64::from(k) + if k % 2 == 0 { 5e-5 } else { -5e-5 }).collect();
        time.remove(500);
        for t in &mut time[700..] {
            *t += 2.0;
        }
        let line: Vec<u32> = (2..).take(time.len()).collect();
        let s = sampling(&time);
        assert!((s.rate_hz - 100.0).abs() < 1.1, "{s:?}");
        assert!((s.jitter_s - 1e-4).abs() < 2e-6, "{s:?}");
        assert_eq!(s.gaps, 2);
        assert!((s.longest_step_s - 2.01).abs() < 2e-4);
        let (breaks, findings) = find_breaks(&time, &line, &s);
        assert_eq!(breaks, [700]);
        assert_eq!(findings.len(), 1);
        assert!(
            findings[0].sentence.starts_with(
                "2 gaps are longer than 1.5 sampling periods, 2.01 s in all, 16.8 % of the time (rows 501 to 502, 701 to 702)"
            ),
            "{}",
            findings[0].sentence
        );
    }

    /// As a bus that is polled as fast as it goes: 4 kHz, late by 8 ms now and then, and once by 12
    /// ms.
    #[test]
    fn lateness_of_some_milliseconds_ends_no_stretch_at_any_rate() {
        let mut time: Vec<f64> = (0..4000).map(|k| 0.25e-3 * f64::from(k)).collect();
        for (row, late) in [(1000, 0.008), (2000, 0.008), (3000, 0.012)] {
            time[row..].iter_mut().for_each(|t| *t += late);
        }
        let line: Vec<u32> = (2..).take(time.len()).collect();
        let (breaks, findings) = find_breaks(&time, &line, &sampling(&time));
        assert_eq!(breaks, [3000]);
        let said = "inputs are held over 2, the simulation starts anew after 1.";
        assert!(findings[0].sentence.ends_with(said), "{}", findings[0].sentence);
    }

    #[test]
    fn milliseconds_for_seconds_are_suspected() {
        let time: Vec<f64> = (0..100).map(|k| 10.0 * f64::from(k)).collect();
        let line: Vec<u32> = (2..102).collect();
        let (_, findings) = find_breaks(&time, &line, &sampling(&time));
        assert_eq!(findings[0].kind, FindingKind::OddRate);
    }
}
