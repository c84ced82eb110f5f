use crate::channel::{Channel, Mode};
use crate::responder::Responder;
use crate::supervisor::Supervisor;
use crate::{
    AdcSample, BoardConfig, BoardState, BoardStatus, ChannelStatus, ConfigError, Counters, Micros, ValveDrive,
};
use pneudrive_protocol::{Address, CHANNELS, Counts, PACKET_LEN};

/// The ten bytes of an answer, to be sent back to back at once.
pub type Answer = [u8; PACKET_LEN];

/// A board: four channels, the bus responder, and the supervisor over them.
///
/// The crate's front page shows who calls what. Calls come in the order of their times; none of them takes long (the
/// figures on the chip are in `docs/firmware.md`).
#[derive(Debug, Clone)]
pub struct Board {
    responder: Responder,
    supervisor: Supervisor,
    channels: [Channel; CHANNELS],
    commands: [Counts; CHANNELS],
    /// Pressures of the last control step. `None` before the first: a board does not report what it has not measured.
    measured: Option<[Counts; CHANNELS]>,
    loop_period: Micros,
    last_step: Option<Micros>,
    counters: Counters,
}

impl Board {
    /// A board that has just been powered up.
    ///
    /// # Errors
    /// A parameter outside its limits, by name.
    pub fn new(config: BoardConfig, address: Address) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            responder: Responder::new(&config, address),
            supervisor: Supervisor::new(&config),
            channels: config.enabled.map(|enabled| Channel::new(&config, enabled)),
            commands: [config.initial_command; CHANNELS],
            measured: None,
            loop_period: config.loop_period,
            last_step: None,
            counters: Counters::default(),
        })
    }

    /// A byte was heard on the bus; its stop bit ended at `now`.
    ///
    /// If it completes a request to this board, the commands are taken over and the answer is returned, with the
    /// pressures of the last control step. The answer's first start bit must follow after
    /// [`answer_delay`](BoardConfig::answer_delay) and within 20 us of `now`, and its bytes must follow each other without
    /// a pause. Bytes that come while the answer is on the wire are the board's own echo and
    /// are ignored.
    ///
    /// A silence of [`IDLE_GAP_CHARACTERS`](pneudrive_protocol::IDLE_GAP_CHARACTERS) is found from the times of the bytes
    /// to half a character. A caller that does not know them so well passes the time at which it looked, and calls
    /// [`line_idle`](Self::line_idle).
    pub fn receive_byte(&mut self, now: Micros, byte: u8) -> Option<Answer> {
        let request = self.responder.byte(now, byte)?;
        self.commands = request.commands;
        count(&mut self.counters.requests);
        self.supervisor.request(now);
        let answer = request.answer(self.address(), self.measured?);
        self.responder.answered(now);
        count(&mut self.counters.answers);
        Some(answer)
    }

    /// The receiver flagged a byte as damaged (framing, parity, break) or lost one (overrun): the frame is lost.
    pub fn line_error(&mut self, now: Micros) {
        self.responder.error(now);
        count(&mut self.counters.line_errors);
    }

    /// The line has been silent for an idle gap: the next byte starts a frame.
    pub fn line_idle(&mut self, _now: Micros) {
        self.responder.idle();
    }

    /// One control step, to be called every loop period with what the four sensor inputs read; gives the drives of the
    /// four valves until the next step.
    pub fn control_step(&mut self, now: Micros, samples: [AdcSample; CHANNELS]) -> [ValveDrive; CHANNELS] {
        self.count_step(now);
        let mode = self.supervise(now);
        let mut drives = [ValveDrive::FULL_VENT; CHANNELS];
        let mut values = [Counts::MIN; CHANNELS];
        for (index, channel) in self.channels.iter_mut().enumerate() {
            let had_fault = matches!(channel.status(), ChannelStatus::SensorFault(_));
            drives[index] = channel.step(samples[index], self.commands[index], mode);
            values[index] = channel.reported();
            if !had_fault && matches!(channel.status(), ChannelStatus::SensorFault(_)) {
                count(&mut self.counters.sensor_faults);
            }
        }
        self.measured = Some(values);
        drives
    }

    fn supervise(&mut self, now: Micros) -> Mode {
        let before = self.supervisor.state();
        let state = self.supervisor.step(now);
        if before == BoardState::Running && matches!(state, BoardState::Hold | BoardState::Vent) {
            count(&mut self.counters.command_timeouts);
            self.responder.forget_host();
        }
        match state {
            BoardState::Running | BoardState::Hold => Mode::Regulate,
            BoardState::PowerUpVent | BoardState::Vent => Mode::Vent,
        }
    }

    fn count_step(&mut self, now: Micros) {
        count(&mut self.counters.steps);
        let late = Micros::new(self.loop_period.get() * 3 / 2);
        if self.last_step.is_some_and(|last| now.since(last) > late) {
            count(&mut self.counters.late_steps);
        }
        self.last_step = Some(now);
    }

    /// The address it answers to.
    pub fn address(&self) -> Address {
        self.responder.address()
    }

    /// The board at a glance.
    pub fn status(&self) -> BoardStatus {
        BoardStatus {
            state: self.supervisor.state(),
            channels: self.channels.each_ref().map(Channel::status),
            commands: self.commands,
            pressures: self.channels.each_ref().map(Channel::reported),
            counters: Counters { frames: self.responder.statistics(), ..self.counters },
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
