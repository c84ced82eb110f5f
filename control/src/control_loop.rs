use crate::channel::{Channel, Mode};
use crate::port::{Orders, Report};
use crate::supervisor::Supervisor;
use crate::{
    AdcSample, BoardConfig, BoardState, ChannelStatus, ConfigError, ControlStatus, Micros, ValveDrive,
};
use pneudrive_protocol::CHANNELS;

/// A board's control side: four channels and the supervisor over them. The other half of a
/// [`Board`](crate::Board) is the [`BusPort`](crate::BusPort).
#[derive(Debug, Clone)]
pub struct ControlLoop {
    supervisor: Supervisor,
    channels: [Channel; CHANNELS],
    /// Distance of two steps beyond which the second is late.
    late_after: Micros,
    last_step: Option<Micros>,
    longest_interval: Micros,
    drives: [ValveDrive; CHANNELS],
    steps: u32,
    late_steps: u32,
    command_timeouts: u32,
    sensor_faults: u32,
}

/// What a control step gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// The drives of the four valves until the next step.
    pub drives: [ValveDrive; CHANNELS],
    /// For the bus side.
    pub report: Report,
}

impl ControlLoop {
    /// # Errors
    /// A parameter outside its limits, by name.
    pub(crate) fn new(config: &BoardConfig) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            supervisor: Supervisor::new(config),
            channels: config.enabled.map(|enabled| Channel::new(config, enabled)),
            late_after: Micros::new(config.loop_period.get() * 3 / 2),
            last_step: None,
            longest_interval: Micros::ZERO,
            drives: [ValveDrive::FULL_VENT; CHANNELS],
            steps: 0,
            late_steps: 0,
            command_timeouts: 0,
            sensor_faults: 0,
        })
    }

    /// One control step: see [`Board::control_step`](crate::Board::control_step).
    pub fn step(&mut self, now: Micros, samples: [AdcSample; CHANNELS], orders: Orders) -> Step {
        self.count_step(now);
        let was_silent = self.supervisor.host_is_silent();
        let state = self.supervisor.step(now, orders.last_request, orders.too_much_damage);
        // From whatever state: steps that come very late can skip the one in between.
        let host_lost = !was_silent && self.supervisor.host_is_silent();
        if host_lost {
            count(&mut self.command_timeouts);
        }
        let mode = match state {
            BoardState::Running | BoardState::Hold => Mode::Regulate,
            BoardState::PowerUpVent | BoardState::Vent | BoardState::DamageVent => Mode::Vent,
        };
        for (index, channel) in self.channels.iter_mut().enumerate() {
            let had_fault = matches!(channel.status(), ChannelStatus::SensorFault(_));
            self.drives[index] = channel.step(samples[index], orders.commands[index], mode);
            if !had_fault && matches!(channel.status(), ChannelStatus::SensorFault(_)) {
                count(&mut self.sensor_faults);
            }
        }
        Step { drives: self.drives, report: Report { status: self.status(), host_lost } }
    }

    fn count_step(&mut self, now: Micros) {
        count(&mut self.steps);
        if let Some(last) = self.last_step.replace(now) {
            let interval = now.since(last);
            self.longest_interval = self.longest_interval.max(interval);
            if interval > self.late_after {
                count(&mut self.late_steps);
            }
        }
    }

    /// What the last step did.
    pub fn status(&self) -> ControlStatus {
        ControlStatus {
            state: self.supervisor.state(),
            channels: self.channels.each_ref().map(Channel::status),
            pressures: self.channels.each_ref().map(Channel::reported),
            drives: self.drives,
            longest_interval: self.longest_interval,
            steps: self.steps,
            late_steps: self.late_steps,
            command_timeouts: self.command_timeouts,
            sensor_faults: self.sensor_faults,
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
