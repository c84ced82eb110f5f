//! What the node says about itself: one status a bus, one a board, and one of the calibrated model
//! beside a bus.

use crate::bus::RunningBus;
use crate::diagnostic_msgs::DiagnosticStatus;
use crate::refusal::Counters;
use pneudrive_host::poller::BoardState;
use pneudrive_host::statistics::{BoardStatistics, Statistics};
use pneudrive_record::watch::WatchState;
use std::sync::atomic::Ordering;

/// Makes the statuses of one bus, and remembers what it said last.
#[derive(Debug, Default)]
pub struct BusReport {
    before: Before,
}

/// Totals at the last report.
#[derive(Debug, Default)]
struct Before {
    seconds: f64,
    cycles: u64,
    lost: Vec<u64>,
    refused: Vec<u64>,
    unpublished: u64,
}

impl BusReport {
    /// The statuses of `bus`, called `name`, its own first. `None` before the bus thread has made
    /// figures.
    pub fn statuses(&mut self, name: &str, bus: &RunningBus) -> Option<Vec<DiagnosticStatus>> {
        let statistics = bus.poller.statistics()?;
        let dropped = bus.dropped.load(Ordering::Relaxed);
        let refused = bus.published.refused.load(Ordering::Relaxed);
        let published = bus.published.published.load(Ordering::Relaxed);
        let states = [
            ("states published", published),
            ("states refused by DDS", refused),
            ("states dropped before DDS", dropped),
        ];
        let mut statuses = vec![self.bus(name, bus, &statistics, &states)];
        let commands: Vec<_> = bus.gates.iter().map(|gate| gate.counters()).collect();
        for (index, (board, commands)) in statistics.boards.iter().zip(&commands).enumerate() {
            let joint = bus.first_joint + u16::from(board.board);
            let status = self.board(&format!("{name}: joint_{joint}"), &bus.port, index, board, commands);
            let called = bus.gates.get(index).and_then(|gate| gate.names().board());
            statuses.push(match called {
                Some(called) => status.with("board", called),
                None => status,
            });
        }
        let watch = bus.watch.as_ref().map(|watch| watch.status().state());
        statuses.extend(watch.map(|state| watched(&format!("{name}: watch"), bus, &state)));
        self.before = Before {
            seconds: statistics.seconds,
            cycles: statistics.cycles,
            lost: statistics.boards.iter().map(|board| board.lost).collect(),
            refused: commands.iter().map(Counters::refused).collect(),
            unpublished: refused + dropped,
        };
        Some(statuses)
    }

    fn bus(
        &self,
        name: &str,
        bus: &RunningBus,
        statistics: &Statistics,
        states: &[(&str, u64); 3],
    ) -> DiagnosticStatus {
        let seconds = statistics.seconds - self.before.seconds;
        let cycles = statistics.cycles - self.before.cycles;
        let rate_hz = if seconds > 0.0 { cycles as f64 / seconds } else { 0.0 };
        let absent = statistics.boards.iter().filter(|board| is_absent(board.state)).count();
        let unpublished = states[1].1 + states[2].1;
        let is_vented = bus.vent.is_vented();
        let (level, message) = if bus.poller.is_finished() {
            (DiagnosticStatus::ERROR, "the bus has failed".to_owned())
        } else if absent == statistics.boards.len() {
            (DiagnosticStatus::ERROR, "no board answers".to_owned())
        } else if absent > 0 {
            (DiagnosticStatus::WARN, format!("{absent} of {} boards do not answer", statistics.boards.len()))
        } else if is_vented {
            (DiagnosticStatus::WARN, "vented until ~/release is called".to_owned())
        } else if unpublished > self.before.unpublished {
            (DiagnosticStatus::WARN, "states were not published".to_owned())
        } else {
            (DiagnosticStatus::OK, format!("{rate_hz:.1} Hz"))
        };
        let status = DiagnosticStatus {
            level,
            name: name.to_owned(),
            message,
            hardware_id: bus.port.clone(),
            values: Vec::new(),
        };
        let status = status
            .with("vented", is_vented)
            .with("line rate (bit/s)", statistics.baud.unwrap_or_default())
            .with("rate (Hz)", format!("{rate_hz:.1}"))
            .with("rate since start (Hz)", format!("{:.1}", statistics.loop_hz.mean))
            .with("cycle time p99 (us)", format!("{:.0}", statistics.cycle_us.p99))
            .with("cycle time max (us)", format!("{:.0}", statistics.cycle_us.max))
            .with("exchanges", statistics.exchanges)
            .with("lost", statistics.lost)
            .with("rejected", statistics.rejected)
            .with("missed ticks", statistics.missed_ticks)
            .with("unsolicited bytes", statistics.unsolicited_bytes)
            .with("CPU share of the bus thread", format!("{:.3}", statistics.cpu_share));
        states.iter().fold(status, |status, (key, count)| status.with(key, count))
    }

    fn board(
        &self,
        name: &str,
        port: &str,
        index: usize,
        board: &BoardStatistics,
        commands: &Counters,
    ) -> DiagnosticStatus {
        let lost = board.lost - self.before.lost.get(index).unwrap_or(&0);
        let refused = commands.refused() - self.before.refused.get(index).unwrap_or(&0);
        let (level, message) = if is_absent(board.state) {
            (DiagnosticStatus::ERROR, "does not answer".to_owned())
        } else if refused > 0 {
            (DiagnosticStatus::WARN, format!("{refused} command(s) refused"))
        } else if lost > 0 {
            (DiagnosticStatus::WARN, format!("{lost} exchange(s) lost"))
        } else {
            (DiagnosticStatus::OK, "answers".to_owned())
        };
        let status = DiagnosticStatus {
            level,
            name: name.to_owned(),
            message,
            hardware_id: format!("{port} board {}", board.board),
            values: Vec::new(),
        };
        let status = status
            .with("state", format!("{:?}", board.state).to_lowercase())
            .with("packets", format!("{:?}", board.frames).to_lowercase())
            .with("answered", board.answered)
            .with("lost", board.lost)
            .with("rejected", board.rejected)
            .with("commands accepted", commands.accepted)
            .with("commands refused: not in effort", commands.not_in_effort)
            .with("commands refused: wrong length", commands.wrong_length)
            .with("commands refused: wrong names", commands.wrong_names)
            .with("commands refused: not a number", commands.not_finite)
            .with("commands refused: out of range", commands.out_of_range)
            .with("commands refused: stale", commands.stale)
            .with("command timeouts", commands.timeouts);
        let Some(sensors) = &board.sensors else { return status };
        let known = [
            ("supply pressure (kPa)", sensors.supply_kpa),
            ("chip temperature (C)", sensors.chip_c),
            ("5 V of the I2C connector (V)", sensors.rail_v),
        ];
        known.into_iter().fold(status, |status, (key, value)| match value {
            Some(value) => status.with(key, format!("{value:.2}")),
            None => status,
        })
    }
}

/// Whether the rig is as it was.
fn watched(name: &str, bus: &RunningBus, state: &WatchState) -> DiagnosticStatus {
    let message = match (&state.failed, &state.latest) {
        (Some(failed), _) => format!("nothing is watched any more: {failed}"),
        (None, Some(change)) => change.text.clone(),
        (None, None) => state.words(),
    };
    let status = DiagnosticStatus {
        level: if state.is_warning() { DiagnosticStatus::WARN } else { DiagnosticStatus::OK },
        name: name.to_owned(),
        message,
        hardware_id: bus.port.clone(),
        values: Vec::new(),
    };
    let status = status
        .with("channels", state.channels)
        .with("channels watched", state.watched)
        .with("changes", state.changes)
        .with("rows left out", state.rows_left_out);
    let Some(change) = &state.latest else { return status };
    status
        .with("changed channel", &change.channel)
        .with("found at (s)", format!("{:.1}", change.t_s))
        .with("since (s)", format!("{:.1}", change.since_s))
        .with("effect", &change.effect)
        .with("probability", format!("{:.2}", change.probability))
}

fn is_absent(state: BoardState) -> bool {
    matches!(state, BoardState::Missing | BoardState::Unseen)
}
