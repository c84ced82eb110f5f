use crate::agreement::Agreement;
use crate::damage::DamageMonitor;
use crate::desk::ParameterDesk;
use crate::line_rate::LineRateKeeper;
use crate::responder::Responder;
use crate::update::UpdateDesk;
use crate::{
    BoardConfig, ChannelStatus, ConfigError, ControlStatus, I2cSensors, Identity, Micros, ParameterSet,
    Stored,
};
use pneudrive_protocol::pages::{ChipKind, CommitOutcome, SessionOffer};
use pneudrive_protocol::{
    Address, Asked, Baud, CHANNELS, Counts, FrameStatistics, PACKET_LEN, PageRequest, Request,
};

/// Counts above atmosphere that a vented chamber's sensor may read.
const VENTED_MARGIN: u16 = 20;

/// The ten bytes of an answer, to be sent back to back at once.
pub type Answer = [u8; PACKET_LEN];

/// A board's bus side: takes bytes, gives answers, and keeps what the control loop is to do.
///
/// One half of a [`Board`](crate::Board); the other is the [`ControlLoop`](crate::ControlLoop).
/// They are apart so that an interrupt can serve the bus while a control step is being computed:
/// [`orders`](Self::orders) and [`report`](Self::report) are all that the two exchange.
#[derive(Debug, Clone)]
pub struct BusPort {
    responder: Responder,
    orders: Orders,
    /// What the last control step did. `None` before the first: a board does not report what it has
    /// not measured.
    pub(crate) control: Option<ControlStatus>,
    identity: Identity,
    longest_loop: Micros,
    agreement: Agreement,
    damage: DamageMonitor,
    desk: ParameterDesk,
    line_rate: LineRateKeeper,
    sensors: I2cSensors,
    pub(crate) update: UpdateDesk,
    sessions: u32,
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
    /// Too many requests came damaged.
    pub too_much_damage: bool,
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
            orders: Orders {
                commands: [config.initial_command; CHANNELS],
                last_request: None,
                too_much_damage: false,
            },
            agreement: Agreement::new(config.rise_needs_two, config.initial_command),
            damage: DamageMonitor::new(config),
            desk: ParameterDesk::new(ParameterSet::of(config)),
            line_rate: LineRateKeeper::new(config),
            sensors: I2cSensors::new(),
            update: UpdateDesk::unsupported(),
            sessions: 0,
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
        let damaged = self.responder.damaged_requests();
        let asked = self.responder.byte(now, byte);
        if self.responder.damaged_requests() != damaged {
            self.damage.damaged(now);
            self.line_rate.damaged(now);
            self.orders.too_much_damage = self.damage.latched();
        }
        let asked = asked?;
        self.line_rate.heard(now);
        let answer = match asked {
            Asked::Pressures(request) => self.obey(now, &request),
            Asked::Page(request) => self.look_up(now, &request),
        }?;
        self.responder.answered(now);
        Some(answer)
    }

    /// Takes over the commands and answers with the pressures.
    fn obey(&mut self, now: Micros, request: &Request) -> Option<Answer> {
        let commands = self.agreement.take(request.commands);
        if request.is_leave() {
            self.damage.release();
            self.desk.forget();
            self.update.forget();
            self.line_rate.leave();
        }
        let too_much_damage = self.damage.latched();
        self.orders = Orders { commands, last_request: Some(now), too_much_damage };
        self.requests = self.requests.saturating_add(1);
        let answer = request.answer(self.address(), self.control?.pressures);
        self.answers = self.answers.saturating_add(1);
        Some(answer)
    }

    /// Answers a page request, which commands nothing: the command timeout runs on.
    fn look_up(&mut self, now: Micros, request: &PageRequest) -> Option<Answer> {
        self.page_requests = self.page_requests.saturating_add(1);
        self.control.as_ref()?;
        let in_session = request.seal.is_some();
        let words = request.entry().and_then(|entry| self.entry(entry, now, in_session));
        Some(request.answer(words).encode())
    }

    /// Gives a session to the host that asks with this number of its own, unless the board is in
    /// one.
    ///
    /// The session's number is a hash of the seed, of the sessions so far and of when it was asked
    /// for: nothing that was sent in an earlier session, or before a reset, fits it.
    pub(crate) fn offer_session(&mut self, now: Micros, host: u8) -> SessionOffer {
        let words = [self.identity.session_seed, self.sessions, now.get() as u32, host.into()];
        let number = words.into_iter().fold(0, |hash: u32, word| {
            let mixed = (hash ^ word).wrapping_mul(0x85EB_CA6B);
            (mixed ^ mixed >> 15).wrapping_mul(0xC2B2_AE35)
        });
        self.sessions = self.sessions.wrapping_add(1);
        if self.responder.offer_session(number) { SessionOffer::Number(number) } else { SessionOffer::Busy }
    }

    /// The receiver flagged a byte as damaged (framing, parity, break) or lost one (overrun): the
    /// frame is lost.
    pub fn line_error(&mut self, now: Micros) {
        self.responder.error(now);
        self.line_rate.damaged(now);
        self.line_errors = self.line_errors.saturating_add(1);
    }

    /// The line has been silent for an idle gap: the next byte starts a frame.
    pub fn line_idle(&mut self) {
        self.responder.idle();
    }

    /// The last stop bit of an answer had been sent at `now`. Gives the line rate that the board
    /// must listen and speak at from now on, if that is another: a host has asked for it, or
    /// leaves.
    ///
    /// Whoever cannot change its line rate need not call it; the board then stays at the one that
    /// it has.
    pub fn answer_sent(&mut self, now: Micros) -> Option<Baud> {
        self.responder.answer_sent(now);
        let baud = self.line_rate.answer_sent(now)?;
        self.responder.set_baud(baud);
        Some(baud)
    }

    /// Gives the line rate that the board was compiled for if it must go back to it at `now`: no
    /// request has come for 100 ms at another one, or too much came damaged. To be called with
    /// every control step, but not while an answer waits or is being sent.
    pub fn line_rate_due(&mut self, now: Micros) -> Option<Baud> {
        let baud = self.line_rate.due(now)?;
        self.responder.set_baud(baud);
        Some(baud)
    }

    /// The line rate in effect.
    pub fn baud(&self) -> Baud {
        self.line_rate.baud()
    }

    pub(crate) fn line_rate(&mut self) -> &mut LineRateKeeper {
        &mut self.line_rate
    }

    /// What its pages say of the sensors on its I2C connector, for whoever reads them.
    pub fn sensors(&mut self) -> &mut I2cSensors {
        &mut self.sensors
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
            self.desk.forget();
            self.update.forget();
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

    /// What its pages say of it from now on. Until then it is a [native](ChipKind::Native) board
    /// after power-on.
    pub fn identify(&mut self, identity: Identity) {
        self.identity = identity;
    }

    pub(crate) fn identity(&self) -> &Identity {
        &self.identity
    }

    /// What its pages say of its parameters from now on: the values that it was compiled with,
    /// those in effect, and the record that they come from. Until then there is none, and both are
    /// those of its configuration.
    pub fn install_parameters(&mut self, compiled: ParameterSet, in_effect: ParameterSet, stored: &Stored) {
        self.desk.install(compiled, in_effect, stored);
    }

    /// The values that a host wants from now on, once after it has committed them. Whoever runs the
    /// board checks them ([`ParameterSet::apply_to`]), keeps them ([`Stored::save`]) and restarts
    /// it, or says why not ([`end_commit`](Self::end_commit)).
    ///
    /// A commit ends here, with nothing to be kept, if it changes nothing or the board [is not
    /// vented](Self::is_vented).
    pub fn take_commit(&mut self) -> Option<ParameterSet> {
        // All interrupts wait while a board looks, many times a second.
        if !self.desk.is_committed() {
            return None;
        }
        let vented = self.is_vented();
        self.desk.take_commit(vented)
    }

    /// Why what [`take_commit`](Self::take_commit) gave does not take effect.
    pub fn end_commit(&mut self, outcome: CommitOutcome) {
        self.desk.end_commit(outcome);
    }

    pub(crate) fn desk(&mut self) -> &mut ParameterDesk {
        &mut self.desk
    }

    /// Whether a restart, which vents, changes nothing for the robot: every set point is at most 0
    /// kPa, and every chamber whose sensor is believed has at most 20 counts (17 kPa) more, as much
    /// as a sensor's offset may be. A channel with a sensor fault, or that is not in use, vents
    /// already.
    pub fn is_vented(&self) -> bool {
        let Some(control) = self.control else { return false };
        let at_rest = Counts::ATMOSPHERE.get() + VENTED_MARGIN;
        let no_set_point = self.orders.commands.iter().all(|command| *command <= Counts::ATMOSPHERE);
        let no_pressure =
            control.channels.iter().zip(control.pressures).all(|(status, pressure)| match status {
                ChannelStatus::Regulating | ChannelStatus::Venting => pressure.get() <= at_rest,
                ChannelStatus::SensorFault(_) | ChannelStatus::Disabled => true,
            });
        no_set_point && no_pressure
    }

    /// A loop, from its start to the valve pins, took so long. For its pages.
    pub fn loop_took(&mut self, time: Micros) {
        self.longest_loop = self.longest_loop.max(time);
    }

    pub(crate) fn longest_loop(&self) -> Micros {
        self.longest_loop
    }

    /// Packets with this board's address whose CRC did not fit.
    pub fn damaged_requests(&self) -> u32 {
        self.responder.damaged_requests()
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
