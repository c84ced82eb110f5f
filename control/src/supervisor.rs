use crate::{BoardConfig, Micros};

/// What a board as a whole does.
///
/// ```text
///  PowerUpVent --power_up_vent--> Running --command_timeout--> Hold --hold_time--> Vent
///                                   ^                           |                   |
///                                   +------ a valid request ----+-------------------+
///
///  Running, Hold or Vent --too many damaged requests--> DamageVent
///  DamageVent --the host leaves--> Running, Hold or Vent
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BoardState {
    /// All channels vent after power-up. Requests are answered and their commands kept for later.
    PowerUpVent,
    /// Channels follow the host's commands.
    Running,
    /// The host is silent; channels follow its last commands.
    Hold,
    /// The host has been silent for too long; all channels vent.
    Vent,
    /// Too many requests came damaged; all channels vent until the host leaves, or until power-up.
    /// Requests are answered.
    DamageVent,
}

/// Decides the [`BoardState`] from the times of control steps and valid requests.
#[derive(Debug, Clone)]
pub(crate) struct Supervisor {
    power_up_vent: Micros,
    command_timeout: Micros,
    hold_time: Micros,
    first_step: Option<Micros>,
    state: BoardState,
    host_is_silent: bool,
}

impl Supervisor {
    pub(crate) fn new(config: &BoardConfig) -> Self {
        Self {
            power_up_vent: config.power_up_vent,
            command_timeout: config.command_timeout,
            hold_time: config.hold_time,
            first_step: None,
            state: BoardState::PowerUpVent,
            host_is_silent: false,
        }
    }

    /// The state for the control step at `now`, given the time of the last valid request and
    /// whether too many were damaged.
    pub(crate) fn step(
        &mut self,
        now: Micros,
        last_request: Option<Micros>,
        too_much_damage: bool,
    ) -> BoardState {
        let first_step = *self.first_step.get_or_insert(now);
        let power_up_end = first_step.after(self.power_up_vent);
        // The silence of a host that is still booting counts from the end of the power-up vent.
        let silent_since = last_request.map_or(power_up_end, |time| time.max(power_up_end));
        let silence = now.since(silent_since);
        self.host_is_silent = now >= power_up_end && silence >= self.command_timeout;
        self.state = if now < power_up_end {
            BoardState::PowerUpVent
        } else if too_much_damage {
            BoardState::DamageVent
        } else if silence < self.command_timeout {
            BoardState::Running
        } else if silence < self.command_timeout.after(self.hold_time) {
            BoardState::Hold
        } else {
            BoardState::Vent
        };
        self.state
    }

    pub(crate) fn state(&self) -> BoardState {
        self.state
    }

    /// Whether the command timeout has passed since the last valid request.
    pub(crate) fn host_is_silent(&self) -> bool {
        self.host_is_silent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use BoardState::{Hold, PowerUpVent, Running, Vent};

    fn at(micros: u64) -> Micros {
        Micros::new(micros)
    }

    #[test]
    fn every_edge_to_the_microsecond() {
        let mut supervisor = Supervisor::new(&BoardConfig::default());
        // First step at 130 ms; 2 s of vent, 500 ms of patience, 2 s of hold.
        let edges = [
            (130_000, PowerUpVent),
            (2_129_999, PowerUpVent),
            (2_130_000, Running),
            (2_629_999, Running),
            (2_630_000, Hold),
            (4_629_999, Hold),
            (4_630_000, Vent),
            (1_000_000_000_000, Vent),
        ];
        for (micros, state) in edges {
            assert_eq!(supervisor.step(at(micros), None, false), state, "at {micros} us");
        }
    }

    #[test]
    fn a_request_in_any_state_starts_the_silence_anew() {
        let mut supervisor = Supervisor::new(&BoardConfig::default());
        supervisor.step(at(0), None, false);
        // While it runs, holds, and vents.
        for heard in [2_100_000, 2_900_000, 60_000_000] {
            let mut step = |micros| supervisor.step(at(micros), Some(at(heard)), false);
            assert_eq!(step(heard), Running);
            assert_eq!(step(heard + 499_999), Running);
            assert_eq!(step(heard + 500_000), Hold);
            assert_eq!(step(heard + 2_500_000), Vent);
        }
    }

    #[test]
    fn a_request_does_not_shorten_the_power_up_vent() {
        let mut supervisor = Supervisor::new(&BoardConfig::default());
        supervisor.step(at(0), None, false);
        let mut step = |micros| supervisor.step(at(micros), Some(at(1_000)), false);
        assert_eq!(step(1_999_999), PowerUpVent);
        assert_eq!(step(2_499_999), Running);
        assert_eq!(step(2_500_000), Hold);
    }

    #[test]
    fn without_times_to_wait_it_skips_states() {
        let config =
            BoardConfig { power_up_vent: Micros::ZERO, hold_time: Micros::ZERO, ..BoardConfig::default() };
        let mut supervisor = Supervisor::new(&config);
        assert_eq!(supervisor.step(at(0), None, false), Running);
        assert_eq!(supervisor.step(at(500_000), None, false), Vent);
    }
}
