use crate::responder::Responder;
use crate::{BoardConfig, ConfigError, Micros};
use pneudrive_protocol::{Address, CHANNELS, Counts, FrameStatistics, PACKET_LEN};

/// The ten bytes of an answer, to be sent back to back at once.
pub type Answer = [u8; PACKET_LEN];

/// A board's bus side: takes bytes, gives answers, and keeps what the control loop is to do.
///
/// One half of a [`Board`](crate::Board); the other is the [`ControlLoop`](crate::ControlLoop). They are apart so that
/// an interrupt can serve the bus while a control step is being computed: [`orders`](Self::orders) and
/// [`report`](Self::report) are all that the two exchange.
#[derive(Debug, Clone)]
pub struct BusPort {
    responder: Responder,
    orders: Orders,
    /// Pressures of the last control step. `None` before the first: a board does not report what it has not measured.
    measured: Option<[Counts; CHANNELS]>,
    requests: u32,
    answers: u32,
    line_errors: u32,
}

/// What the host wants, for the control loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Orders {
    /// Set points of channels 0 to 3.
    pub commands: [Counts; CHANNELS],
    /// When the last request to this board ended.
    pub last_request: Option<Micros>,
}

/// What a control step has to tell the bus side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// What answers carry from now on: filtered pressures, or [`SensorFault::reported`](crate::SensorFault::reported).
    pub pressures: [Counts; CHANNELS],
    /// The host has just been found silent; the next one may speak the other of the two formats.
    pub host_lost: bool,
}

impl BusPort {
    /// # Errors
    /// A parameter outside its limits, by name.
    pub(crate) fn new(config: &BoardConfig, address: Address) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self {
            responder: Responder::new(config, address),
            orders: Orders { commands: [config.initial_command; CHANNELS], last_request: None },
            measured: None,
            requests: 0,
            answers: 0,
            line_errors: 0,
        })
    }

    /// A byte was heard on the bus: see [`Board::receive_byte`](crate::Board::receive_byte).
    pub fn receive_byte(&mut self, now: Micros, byte: u8) -> Option<Answer> {
        let request = self.responder.byte(now, byte)?;
        self.orders = Orders { commands: request.commands, last_request: Some(now) };
        self.requests = self.requests.saturating_add(1);
        let answer = request.answer(self.address(), self.measured?);
        self.responder.answered(now);
        self.answers = self.answers.saturating_add(1);
        Some(answer)
    }

    /// The receiver flagged a byte as damaged (framing, parity, break) or lost one (overrun): the frame is lost.
    pub fn line_error(&mut self, now: Micros) {
        self.responder.error(now);
        self.line_errors = self.line_errors.saturating_add(1);
    }

    /// The line has been silent for an idle gap: the next byte starts a frame.
    pub fn line_idle(&mut self) {
        self.responder.idle();
    }

    /// What the next control step is to do.
    pub fn orders(&self) -> Orders {
        self.orders
    }

    /// Takes over what a control step found.
    pub fn report(&mut self, report: Report) {
        self.measured = Some(report.pressures);
        if report.host_lost {
            self.responder.forget_host();
        }
    }

    /// The address it answers to.
    pub fn address(&self) -> Address {
        self.responder.address()
    }

    /// Valid requests to this board.
    pub fn requests(&self) -> u32 {
        self.requests
    }

    /// Answers handed out. Fewer than requests only if a request came before the first control step.
    pub fn answers(&self) -> u32 {
        self.answers
    }

    /// Bytes the receiver flagged as damaged.
    pub fn line_errors(&self) -> u32 {
        self.line_errors
    }

    /// Packets on the bus (anybody's), and bytes that belonged to none.
    pub fn frames(&self) -> FrameStatistics {
        self.responder.statistics()
    }
}
