//! Looks at the run thirty times a second, and tells the hub.

use crate::picture::Picture;
use crate::recordings::RecordingStatus;
use crate::reply::text;
use crate::run::WatchMoment;
use crate::server::Shared;
use serde::Serialize;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

pub(crate) const PICTURES_HZ: u32 = 30;
/// Pictures between two requests for the run's figures: half a second.
const FIGURES_EVERY: u32 = 15;

/// What changes slowly.
#[derive(Debug, Serialize)]
struct Figures {
    statistics: serde_json::Value,
    watch: Option<WatchMoment>,
    recording: Option<RecordingStatus>,
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
pub(crate) fn run(server: &Shared) {
    let (hub, run) = (&server.hub, &*server.run);
    let mut rate = Rate::default();
    let mut due = Instant::now();
    for number in 0.. {
        if hub.has_ended() {
            return;
        }
        if number % FIGURES_EVERY == 0 {
            hub.figures(figures(server));
        }
        for line in run.lines() {
            hub.line(&line);
        }
        if let Some(moment) = run.moment() {
            let hz = rate.add(moment.since_start_ns, moment.cycle);
            let picture = Picture::new(&moment, hz, server.deadman().0.is_armed());
            hub.picture(picture.t, text(&picture), |history| {
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

fn figures(server: &Shared) -> String {
    let recording = server.options.recordings.as_ref().map(|recordings| recordings.status());
    text(&Figures { statistics: server.run.statistics(), watch: server.run.watch(), recording })
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
