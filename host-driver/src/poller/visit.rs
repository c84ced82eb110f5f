//! One board is asked, and what becomes of its answer.

use super::cycle::Polling;
use super::{BoardCommand, BoardState, Event, Outcome, Reading};
use crate::bus::{Answer, ExchangeError};
use crate::line::{Line, LineError};

impl<L: Line> Polling<L> {
    /// When the board at `index` can be asked: not while it is missing and not probed, nor while it
    /// may still answer.
    pub(super) fn ready_at_ns(&self, index: usize) -> u64 {
        self.presence[index].due_ns().max(self.bus.ready_at_ns(self.rows[index].board))
    }

    pub(super) fn visit(&mut self, index: usize) -> Result<(), LineError> {
        self.rows[index].drives = None;
        self.rows[index].sensors.grow_old();
        if self.ready_at_ns(index) > self.bus.line().now_ns() {
            self.rows[index].outcome = Outcome::NotAsked;
            return Ok(());
        }
        let (board, wanted) = (self.rows[index].board, self.wanted[index]);
        // Looked at as late as possible, so that a vent does not wait for the next cycle.
        let vented = self.stale || self.options.vent.is_vented();
        let (now_ns, was_away) = (self.bus.line().now_ns(), self.slews[index].is_away());
        let command = self.slews[index].step(now_ns, wanted, vented);
        if !(was_away || vented) {
            self.look_for_pause(index, now_ns);
        }
        let command = self.command_sent(board, command);
        let slew = &self.slews[index];
        self.rows[index].wanted =
            if vented { slew.vented() } else { wanted.map(|counts| slew.meant(counts)) };
        self.rows[index].command = command;
        let latest_end_ns = self.bus.line().now_ns() + self.bus.times().longest_exchange_ns();
        let result = self.bus.exchange(board, command);
        let now_ns = self.bus.line().now_ns();
        self.stalled(now_ns, latest_end_ns);
        let error = match result {
            Ok(answer) => {
                self.take(index, &answer);
                None
            }
            Err(ExchangeError::Line(error)) => return Err(error),
            Err(error) => {
                self.rows[index].outcome = Outcome::Lost;
                self.presence[index].failed(now_ns);
                Some(error)
            }
        };
        let answered = error.is_none();
        self.report(index, error.as_ref());
        if answered {
            self.ask_for_drives(index)?;
            self.ask_for_sensors(index)?;
        }
        Ok(())
    }

    /// Whether a board that is there is sent 0 kPa from now on where it was sent more.
    fn look_for_pause(&mut self, index: usize, now_ns: u64) {
        let (row, slew) = (&self.rows[index], &self.slews[index]);
        let is_there = matches!(row.state, BoardState::Present | BoardState::Doubtful);
        if slew.is_away() && is_there && row.wanted != slew.vented() {
            self.paused.push(row.board);
            self.unheard = self.unheard.max(slew.unheard(now_ns));
        }
    }

    /// The command as it stands on the wire: the bus sends some set points a count lower. Told
    /// once.
    fn command_sent(&mut self, board: u8, wanted: BoardCommand) -> BoardCommand {
        let sent = self.bus.commands_on_the_wire(wanted);
        if sent != wanted && !std::mem::replace(&mut self.lowered_told, true) {
            self.tell(&Event::CommandLowered { board, wanted, sent });
        }
        sent
    }

    fn take(&mut self, index: usize, answer: &Answer) {
        self.round_trips.add(answer.round_trip_ns());
        let row = &mut self.rows[index];
        let scales = &self.scales[index];
        let sample = std::array::from_fn(|channel| scales[channel].kpa(answer.pressures[channel]));
        // A board that was away may come back with anything: its old pressures are no history.
        let was_away = self.presence[index].was_away();
        let before = row.reading.filter(|old| !was_away && old.asked_ns >= self.line_since_ns);
        let kpa = match self.options.filter {
            Some(filter) => filter.step(before.map(|reading| reading.kpa), sample),
            None => sample,
        };
        row.reading = Some(Reading { counts: answer.pressures, kpa, asked_ns: answer.sent_ns });
        row.outcome = Outcome::Fresh;
        self.presence[index].answered();
        self.slews[index].answered(answer.answered_ns, answer.pressures);
    }

    fn report(&mut self, index: usize, error: Option<&ExchangeError>) {
        let (row, state) = (&mut self.rows[index], self.presence[index].state());
        if row.state == state {
            return;
        }
        row.state = state;
        let board = row.board;
        let event = Event::Board { board, state, error, host_late: self.late() };
        self.tell(&event);
    }
}
