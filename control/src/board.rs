use crate::{
    AdcSample, Answer, BoardConfig, BoardStatus, BusPort, ConfigError, ControlLoop, ControlStatus, Counters,
    Identity, Micros, ValveDrive,
};
use pneudrive_protocol::{Address, Baud, CHANNELS};

/// A board: its bus side and its control side together.
///
/// The crate's front page shows who calls what. Calls come in the order of their times.
#[derive(Debug, Clone)]
pub struct Board {
    port: BusPort,
    control: ControlLoop,
}

impl Board {
    /// A board that has just been powered up.
    ///
    /// # Errors
    /// A parameter outside its limits, by name.
    pub fn new(config: BoardConfig, address: Address) -> Result<Self, ConfigError> {
        Ok(Self { port: BusPort::new(&config, address)?, control: ControlLoop::new(&config)? })
    }

    /// The two halves, for firmware that serves the bus from an interrupt. What
    /// [`control_step`](Self::control_step) does in one go is then: [`BusPort::orders`],
    /// [`ControlLoop::step`], [`BusPort::report`].
    pub fn split(self) -> (BusPort, ControlLoop) {
        (self.port, self.control)
    }

    /// A byte was heard on the bus; its stop bit ended at `now`.
    ///
    /// If it completes a request to this board, the commands are taken over and the answer is
    /// returned, with the pressures of the last control step. The answer's first start bit must
    /// follow after [`answer_delay`](BoardConfig::answer_delay) and within 20 us of `now`, and its
    /// bytes must follow each other without a pause. Bytes that come while the answer is on the
    /// wire are the board's own echo and are ignored.
    ///
    /// A silence of [`IDLE_GAP_CHARACTERS`](pneudrive_protocol::IDLE_GAP_CHARACTERS) is found from
    /// the times of the bytes to half a character. A caller that does not know them so well passes
    /// the time at which it looked, and calls [`line_idle`](Self::line_idle).
    pub fn receive_byte(&mut self, now: Micros, byte: u8) -> Option<Answer> {
        self.port.receive_byte(now, byte)
    }

    /// The receiver flagged a byte as damaged (framing, parity, break) or lost one (overrun): the
    /// frame is lost.
    pub fn line_error(&mut self, now: Micros) {
        self.port.line_error(now);
    }

    /// The line has been silent for an idle gap: the next byte starts a frame.
    pub fn line_idle(&mut self, _now: Micros) {
        self.port.line_idle();
    }

    /// One control step, to be called every loop period with what the four sensor inputs read;
    /// gives the drives of the four valves until the next step.
    pub fn control_step(&mut self, now: Micros, samples: [AdcSample; CHANNELS]) -> [ValveDrive; CHANNELS] {
        let step = self.control.step(now, samples, self.port.orders());
        self.port.report(step.report);
        step.drives
    }

    /// What its pages say of it from now on: see [`BusPort::identify`].
    pub fn identify(&mut self, identity: Identity) {
        self.port.identify(identity);
    }

    /// Its bus side, for what only that knows.
    pub fn port(&mut self) -> &mut BusPort {
        &mut self.port
    }

    /// The address it answers to.
    pub fn address(&self) -> Address {
        self.port.address()
    }

    /// The line rate at which it speaks and listens.
    pub fn baud(&self) -> Baud {
        self.port.baud()
    }

    /// The board at a glance.
    pub fn status(&self) -> BoardStatus {
        BoardStatus::new(&self.port, self.control.status())
    }
}

impl BoardStatus {
    /// From a board's two halves.
    pub fn new(port: &BusPort, control: ControlStatus) -> Self {
        Self {
            state: control.state,
            channels: control.channels,
            commands: port.orders().commands,
            pressures: control.pressures,
            counters: Counters {
                requests: port.requests(),
                answers: port.answers(),
                page_requests: port.page_requests(),
                line_errors: port.line_errors(),
                damaged_requests: port.damaged_requests(),
                frames: port.frames(),
                steps: control.steps,
                late_steps: control.late_steps,
                command_timeouts: control.command_timeouts,
                sensor_faults: control.sensor_faults,
            },
        }
    }
}
