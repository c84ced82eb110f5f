use crate::responder::Responder;
use crate::{BoardConfig, ConfigError, ControlStatus, Identity, Micros};
use pneudrive_protocol::pages::ChipKind;
use pneudrive_protocol::{
    Address, Asked, CHANNELS, Counts, FrameStatistics, PACKET_LEN, PageRequest, Request,
};

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
    /// What the last control step did. `None` before the first: a board does not report what it has not measured.
    control: Option<ControlStatus>,
    identity: Identity,
    longest_loop: Micros,
    requests: u32,
    answers: u32,
    page_requests: u32,
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
    /// What answers carry from now on, and pages say.
    pub status: ControlStatus,
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
            control: None,
            identity: Identity::of_chip(ChipKind::Native),
            longest_loop: Micros::ZERO,
            requests: 0,
            answers: 0,
            page_requests: 0,
            line_errors: 0,
        })
    }

    /// A byte was heard on the bus: see [`Board::receive_byte`](crate::Board::receive_byte).
    pub fn receive_byte(&mut self, now: Micros, byte: u8) -> Option<Answer> {
        let answer = match self.responder.byte(now, byte)? {
            Asked::Pressures(request) => self.obey(now, &request),
            Asked::Page(request) => self.look_up(now, &request),
        }?;
        self.responder.answered(now);
        Some(answer)
    }

    /// Takes over the commands and answers with the pressures.
    fn obey(&mut self, now: Micros, request: &Request) -> Option<Answer> {
        self.orders = Orders { commands: request.commands, last_request: Some(now) };
        self.requests = self.requests.saturating_add(1);
        let answer = request.answer(self.address(), self.control?.pressures);
        self.answers = self.answers.saturating_add(1);
        Some(answer)
    }

    /// Answers a page request, which commands nothing: the command timeout runs on.
    fn look_up(&mut self, now: Micros, request: &PageRequest) -> Option<Answer> {
        self.page_requests = self.page_requests.saturating_add(1);
        let control = self.control?;
        let words = request.entry().map(|entry| self.entry(entry, &control, now));
        Some(request.answer(words).encode())
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
        self.control = Some(report.status);
        if report.host_lost {
            self.responder.forget_host();
        }
    }

    /// The address it answers to.
    pub fn address(&self) -> Address {
        self.responder.address()
    }

    /// Valid requests to this board with commands.
    pub fn requests(&self) -> u32 {
        self.requests
    }

    /// Answers to them. Fewer than requests only if a request came before the first control step.
    pub fn answers(&self) -> u32 {
        self.answers
    }

    /// Page requests to this board.
    pub fn page_requests(&self) -> u32 {
        self.page_requests
    }

    /// What its pages say of it from now on. Until then it is a [native](ChipKind::Native) board after power-on.
    pub fn identify(&mut self, identity: Identity) {
        self.identity = identity;
    }

    pub(crate) fn identity(&self) -> &Identity {
        &self.identity
    }

    /// A loop, from its start to the valve pins, took so long. For its pages.
    pub fn loop_took(&mut self, time: Micros) {
        self.longest_loop = self.longest_loop.max(time);
    }

    pub(crate) fn longest_loop(&self) -> Micros {
        self.longest_loop
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
