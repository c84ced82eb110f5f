//! Looks at the run thirty times a second, and tells the hub.

use super::WebOptions;
use super::hub::Hub;
use super::picture::Picture;
use crate::line::Clock;
use crate::poller::Monitor;
use crate::statistics::Statistics;
use serde::Serialize;
use std::collections::VecDeque;
use std::sync::PoisonError;
use std::time::{Duration, Instant};

pub(super) const PICTURES_HZ: u32 = 30;
/// Pictures between two requests for the run's figures: half a second.
const FIGURES_EVERY: u32 = 15;

/// What changes slowly.
#[derive(Debug, Serialize)]
struct Figures<'a> {
    statistics: Option<&'a Statistics>,
    recording: Option<RecordingFigures>,
}

/// The recording by button.
#[derive(Debug, Serialize)]
struct RecordingFigures {
    /// The one in progress: file and bytes on the disk.
    running: Option<(String, u64)>,
    finishing: bool,
    /// What became of the one before.
    last: Option<String>,
    failed: bool,
}

/// Cycles per second over the last second.
#[derive(Debug, Default)]
struct Rate {
    progress: VecDeque<(u64, u64)>,
}

impl Rate {
    fn add(&mut self, since_start_ns: u64, cycle: u64) -> Option<f64> {
        if self.progress.back().is_none_or(|(_, last)| *last != cycle) {
            self.progress.push_back((since_start_ns, cycle));
        }
        while self.progress.len() > 2 && self.progress.front()?.0 + 1_000_000_000 < since_start_ns {
            self.progress.pop_front();
        }
        let (first, last) = (self.progress.front()?, self.progress.back()?);
        let seconds = last.0.checked_sub(first.0).filter(|&ns| ns > 0)? as f64 * 1e-9;
        Some((last.1 - first.1) as f64 / seconds)
    }
}

/// Until the hub has ended.
pub(super) fn run(hub: &Hub, options: &WebOptions, monitor: &Monitor, clock: Clock) {
    let mut rate = Rate::default();
    let mut due = Instant::now();
    for number in 0.. {
        if hub.has_ended() {
            return;
        }
        if number % FIGURES_EVERY == 0 {
            hub.figures(figures(options, monitor));
        }
        let snapshot = monitor.latest();
        for text in lines(options) {
            hub.line(line(snapshot.since_start_ns, &text));
        }
        if let Some(cycle) = snapshot.cycle {
            let hz = rate.add(snapshot.since_start_ns, cycle);
            let picture = Picture::new(&snapshot, clock, hz, options.overriding.commanding());
            hub.picture(text(&picture), |history| {
                let channels = picture.boards.iter().flat_map(|board| board.c.into_iter().zip(board.p));
                history.add(picture.t, channels);
            });
        }
        due += Duration::from_secs(1) / PICTURES_HZ;
        match due.checked_duration_since(Instant::now()) {
            Some(rest) => std::thread::sleep(rest),
            // Pictures that come late are left out.
            None => due = Instant::now(),
        }
    }
}

/// A line as it is sent, JSON.
fn line(since_start_ns: u64, text: &str) -> String {
    let tenths = since_start_ns / 100_000_000;
    serde_json::json!({ "t": tenths as f64 / 10.0, "text": text }).to_string()
}

/// What has happened on the bus since last time.
fn lines(options: &WebOptions) -> Vec<String> {
    let lines = options.lines.as_ref().map(|lines| lines.lock().unwrap_or_else(PoisonError::into_inner));
    lines.map_or_else(Vec::new, |lines| lines.try_iter().collect())
}

fn figures(options: &WebOptions, monitor: &Monitor) -> String {
    let statistics = monitor.statistics();
    text(&Figures { statistics: statistics.as_ref(), recording: recording(options) })
}

fn recording(options: &WebOptions) -> Option<RecordingFigures> {
    let status = options.recording.as_ref()?.switch.status();
    let name = |file: &std::path::Path| {
        file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    };
    Some(RecordingFigures {
        running: status.running.map(|file| {
            let bytes = file.metadata().map_or(0, |status| status.len());
            (name(&file), bytes)
        }),
        finishing: status.finishing,
        failed: matches!(status.last, Some(Err(_))),
        last: status.last.map(|last| match last {
            Ok(summary) => {
                format!("{}: {} rows, {} bytes", name(&summary.file), summary.rows, summary.bytes)
            }
            Err(error) => error.to_string(),
        }),
    })
}

fn text(value: &impl Serialize) -> String {
    // These types have neither maps nor failing serializers.
    serde_json::to_string(value).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_of_the_last_second() {
        let mut rate = Rate::default();
        assert_eq!(rate.add(0, 0), None);
        // A second at 100 Hz, then two at 200 Hz, looked at every 50 ms.
        let mut last = None;
        for look in 1..=60u64 {
            let cycle = if look <= 20 { 5 * look } else { 100 + 10 * (look - 20) };
            last = rate.add(look * 50_000_000, cycle);
            if look == 20 {
                assert_eq!(last, Some(100.0));
            }
        }
        assert_eq!(last, Some(200.0));
    }

    /// One cycle every two seconds: the rate is that of the last two cycles that were seen.
    #[test]
    fn a_slow_bus_has_a_rate_too() {
        let mut rate = Rate::default();
        for cycle in 0..3 {
            for _ in 0..60 {
                rate.add(cycle * 2_000_000_000, cycle);
            }
        }
        assert_eq!(rate.add(4_000_000_000, 2), Some(0.5));
    }
}
